// SPDX-License-Identifier: Apache-2.0
#include "bridge/duplicate_node.hpp"

#include "node/node_object.hpp"

#include <utility>

namespace vdrive::canopen {
namespace {

constexpr std::uint16_t kSwitchOnDisabled = 0x0240;  // 6041h, and remote

DriveView drive_at_rest() {
  DriveView drive;
  drive.status.ds402_statusword = kSwitchOnDisabled;
  return drive;
}

}  // namespace

DuplicateNode::DuplicateNode(const NodeSettings& settings, Send send, DriveTime now)
    : send_(std::move(send)), node_(settings, *this) {
  node_.start(drive_at_rest(), now);
}

void DuplicateNode::receive(const Frame& frame, DriveTime now) {
  node_.receive(frame, now);
  while (access_) {
    const DriveAccess access = *std::exchange(access_, std::nullopt);
    node_.complete(access.ticket, {.value = initial_value(access.object)}, now);
  }
}

void DuplicateNode::advance(DriveTime now) {
  const auto due = node_.next_due();
  if (due && *due <= now) node_.advance(now);
}

}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
#include "churn/roles.hpp"
#include "service/probe.hpp"

#include <unistd.h>

#include <array>
#include <limits>

namespace vdrive::churn {
namespace {

using test::Probe;

constexpr std::uint32_t kRamp = 40'000;  // [UU/s²]
constexpr std::int32_t kFar = 2'000'000'000;
constexpr std::size_t kBlock = 256;  // axes per frame and per request

std::uint32_t members_of_set_point() {
  return msg::HAS_DS402_CONTROLWORD | msg::HAS_OP_MODE_CMD | msg::HAS_POSITION_USER_TARGET_VALUE |
         msg::HAS_PROFILE_VELOCITY | msg::HAS_PROFILE_ACC | msg::HAS_PROFILE_DEC;
}

/// Sends the controlword to all axes of the block, with or without the far set-point.
/// @return whether every axis accepted it.
bool send(Probe& probe, const std::vector<std::uint16_t>& axes, std::uint16_t word, bool moves) {
  auto frame = probe.make_frame();
  for (const std::uint16_t axis : axes) {
    auto& command = frame.axes.emplace_back();
    command.axis = axis;
    command.ds402_controlword = word;
    command.members = msg::HAS_DS402_CONTROLWORD;
    if (!moves) continue;
    command.members = static_cast<std::uint16_t>(members_of_set_point());
    command.op_mode_cmd = 1;
    command.position_user_target_value = kFar;
    command.profile_velocity = kSteadySpeed;
    command.profile_acc = kRamp;
    command.profile_dec = kRamp;
  }
  const std::uint64_t sequence = frame.sequence_number;
  if (!probe.send(frame)) return false;
  const auto reply = probe.reply_to(sequence);
  return reply && reply->refusals.empty();
}

bool start_block(Probe& probe, const std::vector<std::uint16_t>& axes) {
  const auto acquired = probe.acquire(axes);
  if (!acquired || acquired->reason != msg::Reason::none) return false;
  constexpr std::array<std::uint16_t, 3> kEnable{0x06, 0x07, 0x0F};
  for (const std::uint16_t word : kEnable) {
    if (!send(probe, axes, word, false)) return false;
  }
  return send(probe, axes, 0x3F, true);
}

}  // namespace

int start(const Setting& setting, AxisRange range) {
  Probe probe({.domain = *setting.network.domain, .security = setting.network.security},
              setting.bench);
  probe.client = probe.session = static_cast<std::uint64_t>(getpid());
  if (!probe.find_bench()) {
    print_failure("start", client::Outcome::not_found("no bench"));
    return 1;
  }
  std::vector<std::uint16_t> block;
  for (std::uint32_t axis = range.first; axis <= range.last; ++axis) {
    block.push_back(static_cast<std::uint16_t>(axis));
    if (block.size() < kBlock && axis != range.last) continue;
    // On a busy machine the watchdog can release the axes between two frames.
    int attempts = 3;
    bool moves = start_block(probe, block);
    while (!moves && --attempts > 0) moves = start_block(probe, block);
    if (!moves) {
      print_failure("start", client::Outcome::failed("axes up to " + std::to_string(axis)));
      return 1;
    }
    block.clear();
  }
  // Released axes keep their state, so they continue to move.
  const auto released = probe.exchange(probe.make_request(msg::RequestKind::release));
  print_line({{"started", range.last - range.first + 1}});
  return released ? 0 : 1;
}

}  // namespace vdrive::churn

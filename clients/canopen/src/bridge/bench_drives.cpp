// SPDX-License-Identifier: Apache-2.0
#include "bridge/bench_drives.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace vdrive::canopen {
namespace {

// Each read of a node is a request to the bench, beside the SDOs of masters: all nodes of a bench
// together send 1,000 in a second of drive time at most.
constexpr DriveTime kShortestReadPeriod = std::chrono::milliseconds(10);
constexpr DriveTime kReadPeriodPerNode = std::chrono::milliseconds(1);

DriveTime read_period_of(std::size_t nodes) {
  return std::max(kShortestReadPeriod, kReadPeriodPerNode * static_cast<std::int64_t>(nodes));
}

}  // namespace

BenchDrives::BenchDrives(const BusParts& parts, const client::BenchInfo& info,
                         std::span<const NodePlace> places, std::string label)
    : parts_(parts),
      label_(std::move(label)),
      count_(places.size()),
      nodes_(parts.bus, parts.store, places,
             {.session = parts.session.id(),
              .software_version = VDRIVE_VERSION,
              .read_period = read_period_of(places.size())},
             calls_of_nodes()),
      self_(std::make_shared<BenchDrives*>(this)) {
  const auto notify = [&loop = parts_.loop, self = std::weak_ptr(self_)] {
    asio::post(loop, [self] {
      if (const auto drives = self.lock()) (*drives)->take_news();
    });
  };
  link_ = std::make_unique<BenchLink>(parts_.session, info, label_, parts_.reports, notify);
}

BenchDrives::~BenchDrives() = default;

std::unique_ptr<BenchLink> BenchDrives::close() {
  nodes_.stop();
  self_.reset();
  return std::move(link_);
}

void BenchDrives::take_news() {
  const BenchLink::News news = link_->take_news();
  if (news.was_lost) {
    nodes_.stop();
    report(bridge::Severity::warning, "is silent or has ended: its nodes have left the bus");
  }
  if (!news.newest) return;
  const auto& [observation, time] = *news.newest;
  if (nodes_.is_running()) {
    nodes_.update(observation.axes, time);
    return;
  }
  nodes_.start(observation.axes, time);
  // What a bridge that ended has left behind would hide the next loss.
  for (std::size_t place = 0; place < count_; ++place) link_->tell_connection(place, false);
}

BenchNodes::Calls BenchDrives::calls_of_nodes() {
  return {.access =
              [this](std::size_t place, const DriveAccess& access) {
                const auto answer = [&loop = parts_.loop, self = std::weak_ptr(self_), place,
                                     ticket = access.ticket](const DriveAnswer& answered) {
                  asio::post(loop, [self, place, ticket, answered] {
                    if (const auto drives = self.lock()) {
                      (*drives)->nodes_.complete(place, ticket, answered);
                    }
                  });
                };
                link_->access(place, access, answer);
              },
          .tell_connection =
              [this](std::size_t place, bool is_lost) {
                link_->tell_connection(place, is_lost);
              },
          .cycle_power =
              [this](std::size_t place) {
                link_->cycle_power(place);
              },
          // Behind what the loop has read in this turn: all of it is one frame.
          .set_points =
              [this] {
                asio::post(parts_.loop, [self = std::weak_ptr(self_)] {
                  const auto drives = self.lock();
                  if (!drives || !(*drives)->nodes_.has_set_points()) return;
                  (*drives)->link_->send((*drives)->nodes_.take_set_points());
                });
              },
          .sync = {},
          .read =
              [this](std::size_t place, std::uint32_t ticket,
                     const std::vector<ObjectAddress>& objects) {
                read(place, ticket, objects);
              }};
}

void BenchDrives::read(std::size_t place, std::uint32_t ticket,
                       const std::vector<ObjectAddress>& objects) {
  const auto answer = [&loop = parts_.loop, self = std::weak_ptr(self_), place,
                       ticket](const std::vector<DriveValue>& values) {
    asio::post(loop, [self, place, ticket, values] {
      if (const auto drives = self.lock()) (*drives)->nodes_.take_values(place, ticket, values);
    });
  };
  link_->read(place, objects, answer);
}

std::uint64_t BenchDrives::dropped_set_points() const {
  return link_->dropped_frames() + nodes_.replaced_set_points();
}

void BenchDrives::report(bridge::Severity severity, const std::string& text) const {
  parts_.reports.report(severity, label_, text);
}

}  // namespace vdrive::canopen

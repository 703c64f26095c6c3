// SPDX-License-Identifier: Apache-2.0
#include "bridge/bench_drives.hpp"

#include "bench_link.hpp"
#include "bridge/drive_access.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <mutex>
#include <utility>

namespace vdrive::canopen {
namespace {

// Each read by a node is a request to the bench, in addition to the SDOs of masters: all nodes of a
// bench together send at most 1,000 per second of drive time.
constexpr DriveTime kShortestReadPeriod = std::chrono::milliseconds(10);
constexpr DriveTime kReadPeriodPerNode = std::chrono::milliseconds(1);

DriveTime read_period_of(std::size_t nodes) {
  return std::max(kShortestReadPeriod, kReadPeriodPerNode * static_cast<std::int64_t>(nodes));
}

// Jobs of the link that change the state of a drive.
constexpr bridge::AxisJobs::Kind kConnection = 1;
constexpr bridge::AxisJobs::Kind kPowerCycle = 2;

}  // namespace

bridge::BenchControl::Options control_options(std::string label) {
  return {.label = std::move(label),
          .remedies = {.loss = "its nodes take it again when all of its axes are free",
                       .faults = "bit 7 of 6040h resets them"},
          .is_automatic = true};
}

/// Passes news of the bench from the thread that follows it to the loop.
class BenchDrives::Link final : public bridge::BenchAdapter {
 public:
  /// News of the bench since the last take_news().
  struct News {
    bool was_lost = false;  ///< `newest` is then from after the bench came back
    State newest{};         ///< none = no news
    DriveTime time{};       ///< of `newest`
  };

  /// @param notify called for the first news after each take_news()
  Link(const BusParts& parts, const client::BenchInfo& info, const std::string& label,
       std::function<void()> notify)
      : notify_(std::move(notify)),
        link_(*this, parts.session, parts.reports, info, control_options(label)) {}

  [[nodiscard]] bridge::BenchLink& bench() noexcept { return link_; }

  [[nodiscard]] News take_news() {
    const std::scoped_lock lock(mutex_);
    are_news_ = false;
    return std::exchange(news_, {});
  }

 private:
  void on_open(const client::BenchInfo& info, const std::vector<client::Axis>& /*axes*/) override {
    period_ = info.period;
  }

  void on_state(const State& state) override {
    const auto ticks = static_cast<std::int64_t>(state->axes.front().driven_tick());
    tell([&](News& news) {
      news.newest = state;
      news.time = period_ * ticks;
    });
  }

  void on_lost() override {
    tell([](News& news) {
      news = {.was_lost = true};
    });
  }

  template <typename Change>
  void tell(const Change& change) {
    {
      const std::scoped_lock lock(mutex_);
      change(news_);
      if (std::exchange(are_news_, true)) return;
    }
    notify_();
  }

  const std::function<void()> notify_;
  std::mutex mutex_;  ///< guards news_ and are_news_
  News news_;
  bool are_news_ = false;               ///< notify_ was called for news_
  std::chrono::microseconds period_{};  ///< for the thread that follows the bench
  bridge::BenchLink link_;              ///< last: its threads use the other members
};

template <typename Action>
auto BenchDrives::in_loop(Action action) {
  return [&loop = parts_.loop, self = std::weak_ptr(self_), action](const auto&... values) {
    asio::post(loop, [self, action, values...] {
      if (const auto drives = self.lock()) action(**drives, values...);
    });
  };
}

BenchDrives::BenchDrives(const BusParts& parts, const client::BenchInfo& info,
                         std::span<const NodePlace> places, std::string label)
    : parts_(parts),
      label_(std::move(label)),
      count_(places.size()),
      nodes_(parts.bus, parts.store, *this, places,
             {.session = parts.session.id(),
              .software_version = VDRIVE_VERSION,
              .read_period = read_period_of(places.size())}),
      self_(std::make_shared<BenchDrives*>(this)),
      link_(std::make_shared<Link>(parts_, info, label_, in_loop([](BenchDrives& drives) {
                                     drives.take_news();
                                   }))) {}

BenchDrives::~BenchDrives() = default;

std::shared_ptr<void> BenchDrives::close() {
  nodes_.stop();
  self_.reset();
  return std::move(link_);
}

void BenchDrives::take_news() {
  const Link::News news = link_->take_news();
  if (news.was_lost) {
    nodes_.stop();
    parts_.reports.report(bridge::Severity::warning, label_,
                          "is silent or has ended: its nodes have left the bus");
  }
  if (!news.newest) return;
  if (nodes_.is_running()) {
    nodes_.update(news.newest->axes, news.time);
    return;
  }
  nodes_.start(news.newest->axes, news.time);
  // A loss that an earlier bridge has left in the drives would hide the next one.
  for (std::size_t place = 0; place < count_; ++place) tell_connection(place, false);
}

// ---- requests of the nodes -------------------------------------------------------------------

void BenchDrives::access(std::size_t place, const DriveAccess& access) {
  const auto answer =
      in_loop([place, ticket = access.ticket](BenchDrives& drives, const DriveAnswer& answered) {
        drives.nodes_.complete(place, ticket, answered);
      });
  const auto job = [access, answer](client::Axis& axis) {
    answer(carry_out(axis, access));
  };
  if (link_->bench().post(place, bridge::AxisJobs::kAccess, job)) return;
  answer(DriveAnswer{.abort = AbortCode::cannot_store_or_transfer});
}

void BenchDrives::read(std::size_t place, std::uint32_t ticket,
                       const std::vector<ObjectAddress>& objects) {
  const auto answer =
      in_loop([place, ticket](BenchDrives& drives, const std::vector<DriveValue>& values) {
        drives.nodes_.take_values(place, ticket, values);
      });
  const auto job = [objects, answer](client::Axis& axis) {
    answer(read_values(axis, objects));
  };
  if (link_->bench().post(place, bridge::AxisJobs::kAccess, job)) return;
  answer(std::vector<DriveValue>{});
}

void BenchDrives::tell_connection(std::size_t place, bool is_lost) {
  bridge::BenchLink& link = link_->bench();
  (void)link.post(place, kConnection, [&link, is_lost](client::Axis& axis) {
    link.report(canopen::tell_connection(axis, is_lost), "axis " + to_string(axis.id()));
  });
}

void BenchDrives::cycle_power(std::size_t place) {
  bridge::BenchLink& link = link_->bench();
  (void)link.post(place, kPowerCycle, [&link](client::Axis& axis) {
    link.report(canopen::cycle_power(axis), "axis " + to_string(axis.id()));
  });
}

/// Hands the set-points over once the loop has read everything that is waiting, so that they go
/// into one frame.
void BenchDrives::note_set_points() {
  in_loop([](BenchDrives& drives) {
    if (drives.nodes_.has_set_points()) drives.link_->bench().send(drives.nodes_.take_set_points());
  })();
}

std::uint64_t BenchDrives::dropped_set_points() const {
  return link_->bench().dropped_frames() + nodes_.replaced_set_points();
}

}  // namespace vdrive::canopen

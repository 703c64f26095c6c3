// SPDX-License-Identifier: Apache-2.0
// Whether clients receive every tick of all axes of a realtime bench, and how soon the first one.
//
//   vdrive_follow_benchmark VDRIVED SECONDS CLIENTS [--enabled|--moving] [argument of vdrived...]
//
// --enabled: every axis is powered and holds its position; --moving: every axis moves all the time;
// with neither, no axis has power.
// Each client is a process with a session that follows all axes of bench 1; the figures are those
// of the first client. Prints JSON lines: {"figure":"status_missed_share","axes":1024,"value":...}.
#include "bare_node.hpp"
#include "service_process.hpp"
#include "support/dropped_by_sockets.hpp"
#include "support/test_domain.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace vdrive;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

struct Followed {
  std::size_t axes = 0;
  std::uint64_t samples = 0;
  std::uint64_t missed = 0;
  double first = 0.0;  ///< from the start of the service [s]
};

/// Collects the service's own counters of its ticks.
class States {
 public:
  explicit States(std::uint32_t domain)
      : participant_(
            wire::make_participant({.domain = domain, .role = wire::Role::client}, "benchmark")),
        states_(*participant_, [this](const msg::BenchState& state, const wire::Source&) {
          tick_ = state.tick;
          overruns_ = state.overruns;
          overflows_ = state.queue_overflows;
          jumps_ = state.jumps;
        }) {}

  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

  [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_; }

  [[nodiscard]] std::uint64_t overflows() const noexcept { return overflows_; }

  /// @return how often the tick number jumped. The skipped ticks have no status, so they are not
  ///         lost.
  [[nodiscard]] std::uint64_t jumps() const noexcept { return jumps_; }

 private:
  std::atomic<std::uint64_t> tick_{0};
  std::atomic<std::uint64_t> overruns_{0};
  std::atomic<std::uint64_t> overflows_{0};
  std::atomic<std::uint64_t> jumps_{0};
  std::unique_ptr<wire::Participant> participant_;
  wire::Subscription<msg::BenchState> states_;
};

client::Follower follower_of_all(client::Session& session, Followed& followed) {
  const auto bench = session.find_bench(1);
  if (!bench) throw std::runtime_error(bench.outcome().message());
  std::vector<client::AxisId> axes;
  for (const auto& axis : bench->axes) axes.push_back(axis.id);
  followed.axes = axes.size();
  auto follower = session.follow(std::move(axes), client::Pace::observe);
  if (!follower) throw std::runtime_error(follower.outcome().message());
  return std::move(*follower);
}

/// @param begun called after the first sample
Followed follow(Clock::time_point start, std::chrono::seconds duration,
                const std::function<void()>& begun) {
  Followed followed;
  client::Session session({.domain = test::test_domain(), .bench = 1, .find_timeout = 30s});
  client::Follower follower = follower_of_all(session, followed);
  client::Observation sample;
  if (const auto outcome = follower.next(10s, sample); !outcome) {
    throw std::runtime_error(outcome.message());
  }
  followed.first = std::chrono::duration<double>(Clock::now() - start).count();
  begun();
  const auto end = Clock::now() + duration;
  while (Clock::now() < end) {
    if (const auto outcome = follower.next(1s, sample); !outcome) {
      throw std::runtime_error(outcome.message());
    }
    ++followed.samples;
    followed.missed += sample.missed;
  }
  return followed;
}

/// Keeps every axis of bench 1 enabled until it is destroyed.
class Power {
 public:
  Power() : session_({.domain = test::test_domain(), .bench = 1, .find_timeout = 30s}) {
    auto axes = session_.axes(1);
    if (!axes) throw std::runtime_error(axes.outcome().message());
    axes_ = std::move(*axes);
    for (const auto& outcome : session_.command_each(axes_, client::EachCommand::enable)) {
      if (!outcome) throw std::runtime_error(outcome.message());
    }
  }

  /// Starts moves that last longer than any run, in groups of the largest size.
  void move() {
    constexpr std::size_t kGroup = 256;
    constexpr double kWay = 6.0e7;  // [UU]; takes 3,000 s at the default speed
    const std::span<const client::Axis> axes(axes_);
    for (std::size_t first = 0; first < axes.size(); first += kGroup) {
      const auto part = axes.subspan(first, std::min(kGroup, axes.size() - first));
      auto group = client::AxisGroup::create(session_, part);
      if (!group) throw std::runtime_error(group.outcome().message());
      const Eigen::VectorXd ways =
          Eigen::VectorXd::Constant(static_cast<Eigen::Index>(part.size()), kWay);
      const auto outcome = group->move_by(ways, {.call = {.until = client::Until::in_force}});
      if (!outcome) throw std::runtime_error(outcome.message());
    }
  }

 private:
  client::Session session_;
  std::vector<client::Axis> axes_;
};

int run(const std::string& program, std::chrono::seconds duration, int clients,
        std::vector<std::string> arguments) {
  const bool is_moving = !arguments.empty() && arguments.front() == "--moving";
  const bool is_enabled = is_moving || (!arguments.empty() && arguments.front() == "--enabled");
  if (is_enabled) arguments.erase(arguments.begin());
  static_cast<void>(test::test_domain());  // the other processes use the same domain
  const auto start = Clock::now();
  const test::ServiceProcess service(program, arguments);
  std::vector<std::unique_ptr<bare::Partner>> others;
  for (int count = 1; count < clients; ++count) {
    others.push_back(std::make_unique<bare::Partner>([&] {
      static_cast<void>(follow(start, duration + 30s, [] {}));
    }));
  }
  std::optional<Power> power;
  if (is_enabled) power.emplace();
  if (is_moving) power->move();
  const States states(test::test_domain());
  std::uint64_t overruns = 0;
  std::uint64_t tick = 0;
  std::uint64_t overflows = 0;
  std::uint64_t jumps = 0;
  std::uint64_t dropped = 0;
  double processor = 0.0;
  const auto begin = [&] {
    overruns = states.overruns();
    tick = states.tick();
    overflows = states.overflows();
    jumps = states.jumps();
    dropped = test::dropped_by_sockets();
    processor = service.processor_seconds();
  };
  const Followed followed = follow(start, duration, begin);
  const auto print = [&](const std::string& figure, double value) {
    bare::print_figure(figure, value, followed.axes);
  };
  const auto all = static_cast<double>(followed.samples + followed.missed);
  print("first_status_s", followed.first);
  print("status_samples", static_cast<double>(followed.samples));
  print("status_missed_share", static_cast<double>(followed.missed) / all);
  print("status_missed", static_cast<double>(followed.missed));
  print("lost_in_service", static_cast<double>(states.overflows() - overflows));
  print("tick_jumps", static_cast<double>(states.jumps() - jumps));
  print("frames_dropped_by_sockets", static_cast<double>(test::dropped_by_sockets() - dropped));
  print("overrun_share", static_cast<double>(states.overruns() - overruns) /
                             static_cast<double>(states.tick() - tick));
  print("service_processor_share",
        (service.processor_seconds() - processor) / static_cast<double>(duration.count()));
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 4) {
    std::cerr << "usage: vdrive_follow_benchmark VDRIVED SECONDS CLIENTS [--enabled|--moving] "
                 "[argument...]\n";
    return 2;
  }
  try {
    return run(arguments[1], std::chrono::seconds(std::stoi(arguments[2])), std::stoi(arguments[3]),
               {arguments + 4, arguments + count});
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}

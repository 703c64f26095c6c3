// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/measurement.hpp"

#include "private_bench.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::uint32_t kBench = 1;
// A usual bench has 64 axes. The speed is measured with many more, because the core computes
// several axes at once, and few axes would not use it fully.
constexpr std::size_t kAxesOfLateness = 64;
constexpr std::size_t kAxesOfSteps = 64;
constexpr std::size_t kAxesOfSpeed = 1'024;
constexpr std::array<std::size_t, 7> kAxesOfStreams{64, 256, 1'024, 2'048, 4'096, 8'192, 16'384};

/// The duration of each part.
struct Plan {
  std::chrono::milliseconds lateness;
  std::chrono::milliseconds steps;
  std::chrono::milliseconds speed;
  std::chrono::milliseconds stream;  ///< of each stream
  std::size_t streams;               ///< of kAxesOfStreams
};

constexpr Plan kWhole{10s, 3s, 3s, 4s, kAxesOfStreams.size()};
constexpr Plan kQuick{1s, 500ms, 500ms, 1s, 3};

// Time for a bench and its stream to start, which is not measured.
constexpr auto kSettling = 500ms;
constexpr auto kFind = 30s;

/// Throws if the call has failed: any failure of a bench ends the measurement.
void require(const Outcome& outcome) {
  if (!outcome) throw std::runtime_error(outcome.message());
}

/// The newest BenchState of a domain.
class States {
 public:
  explicit States(std::uint32_t domain)
      : participant_(
            wire::make_participant({.domain = domain, .role = wire::Role::client}, "vdrive bench")),
        states_(*participant_, [this](const msg::BenchState& state, const wire::Source&) {
          const std::scoped_lock lock(mutex_);
          newest_ = state;
          arrived_.notify_all();
        }) {}

  /// @return the newest one; waits for the first.
  [[nodiscard]] msg::BenchState newest() {
    std::unique_lock lock(mutex_);
    if (!arrived_.wait_for(lock, kFind, [this] {
          return newest_.has_value();
        })) {
      throw std::runtime_error("the bench sent no state for 30 s");
    }
    return *newest_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::optional<msg::BenchState> newest_;
  std::unique_ptr<wire::Participant> participant_;
  wire::Subscription<msg::BenchState> states_;
};

Lateness lateness_between(const msg::BenchState& begin, const msg::BenchState& end) {
  Lateness lateness;
  for (std::size_t bin = 0; bin < lateness.bins.size(); ++bin) {
    const auto at = [bin](const msg::BenchState& state) {
      const auto& bins = state.lateness_histogram;
      return bin < bins.size() ? bins[bin] : 0;
    };
    lateness.bins[bin] = at(end) - std::min(at(begin), at(end));
  }
  return lateness;
}

/// The lateness of the operating system alone: the reference for the ticks.
Lateness sleep_and_wake(std::chrono::milliseconds duration, const Interrupt& interrupt) {
  prctl(PR_SET_TIMERSLACK, 1UL);  // NOLINT(*-vararg): the slack of the tick thread
  Lateness lateness;
  auto next = Clock::now();
  const auto end = next + duration;
  while (next < end && !interrupt.happened()) {
    next += 1ms;
    const auto wanted = next.time_since_epoch();
    const timespec time{
        .tv_sec = std::chrono::floor<std::chrono::seconds>(wanted).count(),
        .tv_nsec = (wanted - std::chrono::floor<std::chrono::seconds>(wanted)).count()};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr);
    lateness.add(Clock::now() - next);
  }
  return lateness;
}

std::vector<client::AxisId> axes_of(std::size_t count) {
  std::vector<client::AxisId> axes;
  axes.reserve(count);
  for (std::size_t axis = 1; axis <= count; ++axis) {
    axes.push_back({kBench, static_cast<std::uint16_t>(axis)});
  }
  return axes;
}

/// Sets the action of an interrupt for the lifetime of this object.
class OnInterrupt {
 public:
  template <typename Action>
  OnInterrupt(Interrupt& interrupt, const Action& action) : interrupt_(interrupt) {
    interrupt_.arm(action);
  }

  ~OnInterrupt() { interrupt_.disarm(); }

  OnInterrupt(const OnInterrupt&) = delete;
  OnInterrupt& operator=(const OnInterrupt&) = delete;

 private:
  Interrupt& interrupt_;
};

/// The parts of a measurement, each on its own bench.
class Measuring {
 public:
  Measuring(std::string service, const Plan& plan, Interrupt& interrupt)
      : service_(std::move(service)), plan_(plan), interrupt_(interrupt) {}

  /// @param report called before each part with its name and duration
  template <typename Report>
  Measurement run(const Report& report) {
    Measurement measurement;
    report("lateness of ticks", plan_.lateness);
    measure_lateness(measurement);
    report("round trips of steps", plan_.steps);
    measurement.steps = measure_steps();
    report("speed of the axes", plan_.speed);
    measurement.tick_of_an_axis = measure_speed();
    for (const std::size_t axes : std::span(kAxesOfStreams).first(plan_.streams)) {
      report("status of " + std::to_string(axes) + " axes", plan_.stream);
      measurement.streams.push_back(measure_stream(axes));
      if (!measurement.streams.back().is_whole()) break;
    }
    return measurement;
  }

 private:
  /// Starts a bench and runs `work` with it; an interrupt ends both.
  template <typename Work>
  void with_bench(std::string_view clock, std::size_t axes, const Work& work) {
    process::PrivateBench bench(service_,
                                {"--clock", std::string(clock), "--axes", std::to_string(axes)});
    {
      const OnInterrupt end(interrupt_, [&bench] {
        bench.end();
      });
      if (const auto problem = bench.wait_until_ready()) throw std::runtime_error(*problem);
    }
    client::Session session({.domain = bench.domain(), .bench = kBench, .find_timeout = kFind});
    const OnInterrupt end(interrupt_, [&bench, &session] {
      session.interrupt();
      bench.end();
    });
    require(session.find_bench(kBench).outcome());
    work(session, bench.domain());
    if (interrupt_.happened()) throw std::runtime_error("interrupted");
  }

  /// Measures the ticks and the bare loop at the same time, so that a busy moment affects both.
  void measure_lateness(Measurement& measurement) {
    with_bench("realtime", kAxesOfLateness, [&](client::Session&, std::uint32_t domain) {
      States states(domain);
      (void)states.newest();
      (void)sleep_and_wake(kSettling, interrupt_);
      const msg::BenchState begin = states.newest();
      measurement.bare = sleep_and_wake(plan_.lateness, interrupt_);
      measurement.ticks = lateness_between(begin, states.newest());
    });
  }

  RoundTrips measure_steps() {
    RoundTrips trips;
    with_bench("lockstep", kAxesOfSteps, [&](client::Session& session, std::uint32_t) {
      std::vector<double> times;
      const auto begin = Clock::now();
      while (Clock::now() < begin + plan_.steps) {
        const auto asked = Clock::now();
        require(session.step(kBench, 1).outcome());
        times.push_back(std::chrono::duration<double, std::micro>(Clock::now() - asked).count());
      }
      constexpr double kMost = 0.99;
      const auto seconds = std::chrono::duration<double>(Clock::now() - begin).count();
      trips.per_second = static_cast<double>(times.size()) / seconds;
      std::ranges::sort(times);
      trips.median = times[times.size() / 2];
      trips.p99 = times[static_cast<std::size_t>(kMost * static_cast<double>(times.size() - 1))];
    });
    return trips;
  }

  double measure_speed() {
    double tick_of_an_axis = 0.0;
    with_bench("lockstep", kAxesOfSpeed, [&](client::Session& session, std::uint32_t) {
      set_moving(session);
      std::uint64_t ticks = 0;
      constexpr std::uint64_t kTicks = 1'000;
      const auto begin = Clock::now();
      while (Clock::now() < begin + plan_.speed) {
        require(session.step(kBench, kTicks).outcome());
        ticks += kTicks;
      }
      const std::chrono::duration<double, std::nano> time = Clock::now() - begin;
      tick_of_an_axis = time.count() / static_cast<double>(ticks * kAxesOfSpeed);
    });
    return tick_of_an_axis;
  }

  /// All axes move endlessly, each at a different speed.
  static void set_moving(client::Session& session) {
    constexpr std::int32_t kSlowest = 1'000;
    auto axes = session.axes(kBench);
    require(axes.outcome());
    for (const Outcome& outcome : session.command_each(*axes, client::EachCommand::enable)) {
      require(outcome);
    }
    std::int32_t velocity = kSlowest;
    for (client::Axis& axis : *axes) {
      require(axis.run_at(++velocity, {.call = {.until = client::Until::in_force}}));
    }
  }

  StatusStreamFigures measure_stream(std::size_t axes) {
    StatusStreamFigures figures{.axes = axes};
    with_bench("realtime", axes, [&](client::Session& session, std::uint32_t domain) {
      States states(domain);
      auto follower = session.follow(axes_of(axes), client::Pace::observe);
      require(follower.outcome());
      const auto settled = Clock::now() + kSettling;
      while (Clock::now() < settled) require(follower->next(kFind).outcome());
      const msg::BenchState begin = states.newest();
      const auto end = Clock::now() + plan_.stream;
      while (Clock::now() < end) {
        const auto sample = follower->next(kFind);
        require(sample.outcome());
        ++figures.samples;
        figures.missed += sample->missed;
      }
      const msg::BenchState last = states.newest();
      const auto ticks = static_cast<double>(std::max<std::uint64_t>(last.tick - begin.tick, 1));
      figures.overrun_share = static_cast<double>(last.overruns - begin.overruns) / ticks;
    });
    return figures;
  }

  std::string service_;
  const Plan& plan_;
  Interrupt& interrupt_;
};

}  // namespace

ExitCode run_measurement(const MeasurementOptions& options, Interrupt& interrupt,
                         Terminal& terminal) {
  try {
    Measuring measuring(options.service, options.is_quick ? kQuick : kWhole, interrupt);
    const Measurement measurement =
        measuring.run([&](std::string_view part, std::chrono::milliseconds duration) {
          terminal.print_error("vdrive bench: " + std::string(part) + ", " +
                               rounded(std::chrono::duration<double>(duration).count()) + " s");
        });
    if (options.is_json) {
      terminal.print(to_line(measurement_json(measurement)));
    } else {
      for (const std::string& line : measurement_lines(measurement)) terminal.print(line);
    }
    return ExitCode::ok;
  } catch (const std::runtime_error&) {
    if (!interrupt.happened()) throw;
    return ExitCode::interrupted;
  }
}

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
// A bench in this process and a given vdrived over DDS, both used through the client library and in
// turn: the cost of creating a bench, of stepping it, and of letting drive time pass.
//
//   vdrive_local_benchmark VDRIVED ROUNDS
//
// Prints JSON lines: {"figure":"bench_step_us_p50","over":"local","axes":64,"value":...,"aim":6}.
// The 64 axes move all the time. Percentiles are those of all rounds together;
// bench_shown_above_bare_us is the median of the differences between neighbouring blocks of 50
// steps.
//
// A virtual processor may share a core with another guest and is then slower by half, for
// milliseconds or for hours, which no counter of the guest shows. Therefore a calculation runs
// between the bare steps; it uses no other thread and no system calls. calculation_us shows how the
// machine affects it. bench_step_steady_us counts only the steps between two calculations at full
// speed, which is the speed of the fastest hundredth; bench_step_steady_share is the share of these
// steps.
#include "private_bench.hpp"

#include <Eigen/Core>
#include <vdrive/bench/bench.hpp>
#include <vdrive/client.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace vdrive;
using namespace vdrive::client;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Microseconds = std::chrono::duration<double, std::micro>;

constexpr std::size_t kAxes = 64;
constexpr double kSteady = 1.1;              // times the fastest hundredth of the calculations
constexpr std::size_t kFewest = 1'000;       // so that a hundredth is several steps
constexpr std::size_t kSteps = 5'000;        // of each kind in a round
constexpr std::size_t kBlocks = 100;         // in a round
constexpr std::size_t kKept = 10'000;        // ticks
constexpr std::chrono::seconds kWaited{10};  // of drive time

void require(const Outcome& outcome) {
  if (!outcome) throw std::runtime_error(outcome.message());
}

/// A lock-step bench with a session, in one of the two forms.
class BenchInUse {
 public:
  /// @param service the program vdrived; empty = in this process
  BenchInUse(const std::string& service, std::size_t axes) {
    SessionOptions options;
    options.find_timeout = 30s;
    if (service.empty()) {
      local_.emplace(bench::BenchOptions{.axes = axes});
      options.bus = local_->bus();
    } else {
      const std::vector<std::string> words{"--clock", "lockstep", "--axes", std::to_string(axes)};
      remote_.emplace(service, words);
      if (const auto problem = remote_->wait_until_ready()) throw std::runtime_error(*problem);
      options.domain = remote_->domain();
    }
    session_.emplace(options);
  }

  [[nodiscard]] Session& session() { return *session_; }

 private:
  std::optional<bench::Bench> local_;
  std::optional<process::PrivateBench> remote_;
  std::optional<Session> session_;
};

/// The steps of one kind [us].
struct Steps {
  std::vector<double> times;
  std::vector<double> calculated;  ///< the calculation after each step
};

/// The times of all rounds [us].
struct Times {
  Steps bare;
  Steps shown;
  std::vector<double> above;  ///< median of the shown steps of a block less that of the bare ones
  std::vector<double> kept;
  std::vector<double> waited;
  std::vector<double> lived;
};

struct Form {
  std::string_view over;
  std::string service;
  Times times{};
  std::optional<BenchInUse> moving{};
};

using Forms = std::array<Form, 2>;

/// @return the quantile of the times at `share`.
double quantile(std::vector<double> times, double share) {
  std::ranges::sort(times);
  return times.at(static_cast<std::size_t>(share * static_cast<double>(times.size())));
}

double median(const std::vector<double>& times) {
  return quantile(times, 0.5);
}

/// Some microseconds of arithmetic that keeps the units of a processor as busy as a tick of axes
/// does.
class Calculation {
 public:
  void run() {
    constexpr int kTimes = 80;
    for (int time = 0; time < kTimes; ++time) {
      // y stays between -1 and 1, because its factor is below a half.
      y_ = y_ * 0.5 + (x_ * z_ + 0.25) * (x_ - z_) - y_ * x_;
    }
    result_ = y_.sum();
  }

 private:
  using Values = Eigen::Array<double, kAxes, 1>;

  Values x_ = Values::LinSpaced(0.1, 0.9);
  Values y_ = Values::Zero();
  Values z_ = Values::LinSpaced(0.8, 0.2);
  volatile double result_ = 0.0;
};

template <typename Call>
double time_of(const Call& call) {
  const auto begin = Clock::now();
  call();
  return Microseconds(Clock::now() - begin).count();
}

/// @return the steps before and after which the calculation ran at full speed.
std::vector<double> steady(const Steps& steps) {
  const double limit = kSteady * quantile(steps.calculated, 0.01);
  std::vector<double> times;
  for (std::size_t i = 1; i < steps.times.size(); ++i) {
    const bool is_steady = steps.calculated.at(i - 1) <= limit && steps.calculated.at(i) <= limit;
    if (is_steady) times.push_back(steps.times.at(i));
  }
  return times;
}

void append(std::vector<double>& to, const std::vector<double>& times) {
  to.insert(to.end(), times.begin(), times.end());
}

std::vector<AxisId> ids_of_all(Session& session) {
  std::vector<AxisId> ids;
  for (const Axis& axis : session.axes(1).value()) ids.push_back(axis.id());
  return ids;
}

/// Lets half of the axes move at different speeds and half accelerate, for 40 rounds and more.
void let_all_move(Session& session) {
  for (Axis& axis : session.axes(1).value()) {
    const std::uint32_t number = axis.id().axis;
    const bool cruises = number % 2 == 0;
    require(axis.enable());
    require(axis.move_to(number % 3 == 0 ? -2'000'000'000 : 2'000'000'000,
                         {.velocity = cruises ? 20'000 + 100 * number : 100'000,
                          .acceleration = cruises ? 409'600 : 10 + number,
                          .call = {.until = Until::in_force}}));
  }
  static_cast<void>(session.wait(1, 1s).value());  // until the speed of each is visible
}

/// @return the present tick.
/// @throws std::runtime_error if an axis does not move
std::uint64_t tick_in_motion(Session& session, const std::vector<AxisId>& ids) {
  const Observation present = session.observe(ids).value();
  if (present.axes.size() != kAxes ||
      std::ranges::any_of(present.axes, [](const AxisSnapshot& axis) {
        return axis.status.velocity_demand_value == 0;
      })) {
    throw std::runtime_error("an axis stopped moving");
  }
  return present.tick;
}

/// Measures some steps of a kind. @return their times.
template <typename Step>
std::vector<double> measure_block(const Step& step, Calculation& calculation, Steps& steps) {
  std::vector<double> times;
  for (std::size_t i = 0; i < kSteps / kBlocks; ++i) {
    times.push_back(time_of(step));
    steps.calculated.push_back(time_of([&] {
      calculation.run();
    }));
  }
  append(steps.times, times);
  return times;
}

/// Measures a block of each kind in turn, because the machine changes its speed in the course of a
/// run.
void measure_steps(Session& session, const std::vector<AxisId>& ids, Times& times) {
  Calculation calculation;
  for (std::size_t block = 0; block < kBlocks; ++block) {
    const auto step = [&] {
      static_cast<void>(session.step(1, 1).value());
    };
    const std::vector<double> bare = measure_block(step, calculation, times.bare);
    // Exists for its block only, so that it does not slow the bare steps.
    Follower follower = session.follow(ids, Pace::drive).value();
    Observation sample;
    const auto show = [&] {
      require(follower.next(10s, sample));
    };
    const std::vector<double> shown = measure_block(show, calculation, times.shown);
    times.above.push_back(median(shown) - median(bare));
  }
}

/// @param memory holds the samples of all ticks
void measure_kept(Session& session, const std::vector<AxisId>& ids,
                  std::vector<AxisSnapshot>& memory, Times& times) {
  Follower follower = session.follow(ids, Pace::drive).value();
  Observation sample;
  auto place = memory.begin();
  times.kept.push_back(time_of([&] {
    for (std::size_t tick = 0; tick < kKept; ++tick) {
      require(follower.next(10s, sample));
      place = std::ranges::copy(sample.axes, place).out;
    }
  }));
  if (place != memory.end()) throw std::runtime_error("a sample does not show all axes");
}

void measure_round(Form& form, const std::vector<AxisId>& ids, std::vector<AxisSnapshot>& memory) {
  constexpr std::uint64_t kTicks = 2 * kSteps + kKept + kWaited / 1ms;
  Session& session = form.moving->session();
  const std::uint64_t begin = tick_in_motion(session, ids);
  measure_steps(session, ids, form.times);
  measure_kept(session, ids, memory, form.times);
  form.times.waited.push_back(time_of([&] {
    static_cast<void>(session.wait(1, kWaited).value());
  }));
  if (tick_in_motion(session, ids) != begin + kTicks) {
    throw std::runtime_error("a step was not one of one tick");
  }
}

/// Measures the creation of a bench of two axes, a read from its first axis, and its end.
void measure_life(Form& form) {
  form.times.lived.push_back(time_of([&] {
    BenchInUse bench(form.service, 2);
    static_cast<void>(bench.session().axis("1.1").value().status().value());
  }));
}

/// @param aim for the bench in this process; 0 = none
void print(std::string_view figure, const Form& form, std::size_t axes, double value, double aim) {
  std::cout << R"({"figure":")" << figure << R"(","over":")" << form.over << R"(","axes":)" << axes
            << R"(,"value":)" << value;
  if (aim != 0.0) std::cout << R"(,"aim":)" << aim;
  std::cout << "}\n";
}

void print_steps(const std::string& kind, const Form& form, const Steps& steps, double aim,
                 double aim_of_p99) {
  print(kind + "_us_p50", form, kAxes, median(steps.times), aim);
  print(kind + "_us_p99", form, kAxes, quantile(steps.times, 0.99), aim_of_p99);
  const std::vector<double> at_full_speed = steady(steps);
  print(kind + "_steady_share", form, kAxes,
        static_cast<double>(at_full_speed.size()) / static_cast<double>(steps.times.size()), 0);
  if (at_full_speed.size() < kFewest) return;
  print(kind + "_steady_us_p50", form, kAxes, median(at_full_speed), aim);
  print(kind + "_steady_us_p99", form, kAxes, quantile(at_full_speed, 0.99), aim_of_p99);
}

void print(const Form& form) {
  const Times& times = form.times;
  const bool is_local = form.service.empty();
  const auto aim = [is_local](double value) {
    return is_local ? value : 0.0;
  };
  print_steps("bench_step", form, times.bare, aim(6), aim(10));
  print_steps("bench_shown_step", form, times.shown, aim(8), 0);
  print("calculation_us_p50", form, 0, median(times.bare.calculated), 0);
  print("calculation_us_p99", form, 0, quantile(times.bare.calculated, 0.99), 0);
  print("bench_shown_above_bare_us", form, kAxes, median(times.above), is_local ? 0 : 5);
  print("bench_kept_10_s_ms", form, kAxes, median(times.kept) / 1'000, 0);
  print("bench_waited_10_s_ms", form, kAxes, median(times.waited) / 1'000, aim(25));
  print("bench_life_ms", form, 2, median(times.lived) / 1'000, aim(3));
}

int measure(const std::string& service, int rounds) {
  Forms forms{Form{.over = "local", .service = ""}, Form{.over = "dds", .service = service}};
  // This comes first, because a process with much memory takes longer to start another one.
  for (int round = 0; round < rounds; ++round) {
    for (Form& form : forms) measure_life(form);
  }
  for (Form& form : forms) {
    form.moving.emplace(form.service, kAxes);
    let_all_move(form.moving->session());
  }
  const std::vector<AxisId> ids = ids_of_all(forms.front().moving->session());
  std::vector<AxisSnapshot> memory(kKept * kAxes);
  for (int round = 0; round < rounds; ++round) {
    for (Form& form : forms) measure_round(form, ids, memory);
  }
  for (const Form& form : forms) print(form);
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) {
    std::cerr << "usage: vdrive_local_benchmark VDRIVED ROUNDS\n";
    return 2;
  }
  try {
    return measure(arguments[1], std::stoi(arguments[2]));
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}

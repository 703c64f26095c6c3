// SPDX-License-Identifier: Apache-2.0
//
// Cost of a complete tick of the bank (due writes, drive logic, eight servo sub-steps, monitors,
// status image) with all axes moving, and of planning one move. Prints one JSON line for each
// figure: the median of the repetitions.
#include "figure_reporter.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/motion/jerk_profile.hpp"
#include "vdrive/motion/profile.hpp"

#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <random>
#include <vector>

namespace {

constexpr std::chrono::microseconds kPeriod{1000};
constexpr int kRepetitions = 9;
constexpr int kControlwordLoop = 4;  // 5E20h:06 of axes with a habit [ms, a tick each]

void command(vdrive::AxisBank& bank, std::size_t axis, std::uint16_t index, std::int64_t value) {
  if (bank.write(axis, {index, 0}, value) != vdrive::AbortCode::none) {
    std::cerr << "write refused\n";
    std::abort();
  }
}

/// A feature of the measured axes that is off by default.
enum class Extra { none, jerk, habit };

/// Starts moves that last longer than any benchmark, each with different numbers. Every second axis
/// cruises, the others change their speed all the time; with limited jerk, the others also change
/// their acceleration, for 100 s.
vdrive::AxisBank moving_bank(std::size_t axes, const vdrive::AxisModel& model, Extra extra) {
  const bool has_jerk = extra == Extra::jerk;
  vdrive::AxisConfiguration configuration;
  configuration.model = model;
  if (extra == Extra::habit) configuration.parameters = {{{0x5E20, 0x06}, kControlwordLoop}};
  const std::vector<vdrive::AxisConfiguration> configurations(axes, configuration);
  vdrive::AxisBank bank(configurations, kPeriod);
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const auto spread = static_cast<std::int64_t>(axis % 97);
    const bool cruises = axis % 2 == 0;
    command(bank, axis, 0x6060, 1);
    command(bank, axis, 0x607A, axis % 3 == 0 ? -2'000'000'000 : 2'000'000'000);
    command(bank, axis, 0x6081, cruises ? 20'000 + 100 * spread : 100'000);
    command(bank, axis, 0x6083, cruises || has_jerk ? 409'600 : 40 + spread);
    if (has_jerk) {
      command(bank, axis, 0x6086, 3);
      if (bank.write(axis, {0x60A4, 1}, cruises ? 100'000'000 : 20) != vdrive::AbortCode::none) {
        std::cerr << "write refused\n";
        std::abort();
      }
    }
    command(bank, axis, 0x6040, 0x0F);
  }
  for (int tick = 0; tick < kControlwordLoop; ++tick) bank.step();
  for (std::size_t axis = 0; axis < axes; ++axis) command(bank, axis, 0x6040, 0x3F);
  for (int tick = 0; tick < 300; ++tick) bank.step();
  return bank;
}

bool all_moving(const vdrive::AxisBank& bank) {
  for (std::size_t axis = 0; axis < bank.size(); ++axis) {
    if (bank.status(axis).velocity_demand_value == 0 ||
        bank.status(axis).ds402_statusword != 0x1237) {
      return false;
    }
  }
  return true;
}

/// @return a model with a holding brake, cogging and a motor that heats up too little for a
///         warning.
vdrive::AxisModel with_effects(vdrive::Coupling coupling) {
  return {.coupling = coupling,
          .brake_torque = 2.0,
          .cogging_torque = 0.05,
          .motor_thermal_time_constant = 60.0};
}

/// @return a model with effects that act in each sub-step: encoder noise and ripple. The end stops
///         are out of reach.
vdrive::AxisModel with_noise() {
  return {.torque_ripple = 1.0,
          .encoder_noise = 0.01,
          .load_encoder_noise = 0.01,
          .lower_end_stop = -2.1e9,
          .upper_end_stop = 2.1e9};
}

void tick(benchmark::State& state, const vdrive::AxisModel& model, Extra extra) {
  const auto axes = static_cast<std::size_t>(state.range(0));
  vdrive::AxisBank bank = moving_bank(axes, model, extra);
  for (auto _ : state) bank.step();
  if (!all_moving(bank)) {
    state.SkipWithError("an axis stopped moving: the figure would not be that of moving axes");
  }
  state.counters["value"] = benchmark::Counter(
      1.0e-9 * static_cast<double>(axes),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Measures axes at rest: without power, or at their target.
void tick_at_rest(benchmark::State& state, bool powered) {
  const auto axes = static_cast<std::size_t>(state.range(0));
  const std::vector<vdrive::AxisConfiguration> configurations(axes);
  vdrive::AxisBank bank(configurations, kPeriod);
  for (std::size_t axis = 0; powered && axis < axes; ++axis) {
    command(bank, axis, 0x6060, 1);
    command(bank, axis, 0x6040, 0x0F);
  }
  for (int tick = 0; tick < 300; ++tick) bank.step();
  for (auto _ : state) bank.step();
  const std::uint16_t expected = powered ? 0x0637 : 0x0250;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    if (bank.status(axis).ds402_statusword != expected) {
      state.SkipWithError("an axis is not at rest");
    }
  }
  state.counters["value"] = benchmark::Counter(
      1.0e-9 * static_cast<double>(axes),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void plan(benchmark::State& state) {
  struct Case {
    vdrive::MotionState start;
    double target;
    vdrive::MotionLimits limits;
  };

  std::mt19937_64 random(42);
  std::uniform_real_distribution<double> position(-1.0e6, 1.0e6);
  std::uniform_real_distribution<double> velocity(-1.5e5, 1.5e5);
  std::uniform_real_distribution<double> acceleration(1.0e3, 1.0e6);
  std::vector<Case> cases(4096);
  for (Case& c : cases) {
    c = {{position(random), velocity(random)},
         position(random),
         {std::abs(velocity(random)) + 1.0, acceleration(random), acceleration(random)}};
  }
  std::size_t i = 0;
  for (auto _ : state) {
    const Case& c = cases[i++ % cases.size()];
    benchmark::DoNotOptimize(vdrive::plan_move(c.start, c.target, c.limits));
  }
  state.counters["value"] = benchmark::Counter(
      1.0e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// The cases of `plan` with limited jerk and an acceleration at the start.
void jerk_plan(benchmark::State& state) {
  struct Case {
    vdrive::MotionSample start;
    double target;
    vdrive::MotionLimits limits;
    vdrive::MotionJerk jerk;
  };

  std::mt19937_64 random(42);
  std::uniform_real_distribution<double> position(-1.0e6, 1.0e6);
  std::uniform_real_distribution<double> velocity(-1.5e5, 1.5e5);
  std::uniform_real_distribution<double> acceleration(1.0e3, 1.0e6);
  std::uniform_real_distribution<double> jerk(1.0e4, 1.0e8);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  std::vector<Case> cases(4096);
  for (Case& c : cases) {
    c.limits = {std::abs(velocity(random)) + 1.0, acceleration(random), acceleration(random)};
    c.jerk = {jerk(random), jerk(random)};
    c.start = {position(random), velocity(random), part(random) * c.limits.deceleration};
    c.target = position(random);
  }
  std::size_t i = 0;
  for (auto _ : state) {
    const Case& c = cases[i++ % cases.size()];
    benchmark::DoNotOptimize(vdrive::plan_jerk_move(c.start, c.target, c.limits, c.jerk));
  }
  state.counters["value"] = benchmark::Counter(
      1.0e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RegisterBenchmark("axis_tick_ns", tick, vdrive::AxisModel{}, Extra::none)
      ->Arg(8)
      ->Arg(64)
      ->Arg(256)
      ->Arg(1024)
      ->Arg(4096)
      ->Arg(16384)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("axis_tick_two_inertia_ns", tick,
                               vdrive::AxisModel{.coupling = vdrive::Coupling::two_inertia},
                               Extra::none)
      ->Arg(64)
      ->Arg(1024)
      ->Arg(16384)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("axis_tick_effects_ns", tick, with_effects(vdrive::Coupling::rigid),
                               Extra::none)
      ->Arg(64)
      ->Arg(1024)
      ->Arg(16384)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("axis_tick_two_inertia_effects_ns", tick,
                               with_effects(vdrive::Coupling::two_inertia), Extra::none)
      ->Arg(1024)
      ->Arg(16384)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("axis_tick_jerk_ns", tick, vdrive::AxisModel{}, Extra::jerk)
      ->Arg(1024)
      ->Arg(16384)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("axis_tick_noise_ns", tick, with_noise(), Extra::none)
      ->Arg(1024)
      ->Arg(16384)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("axis_tick_habits_ns", tick, vdrive::AxisModel{}, Extra::habit)
      ->Arg(1024)
      ->Arg(16384)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("axis_tick_standing_ns", tick_at_rest, true)
      ->Arg(1024)
      ->Arg(16384)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("axis_tick_unpowered_ns", tick_at_rest, false)
      ->Arg(1024)
      ->Arg(16384)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("plan_ns", plan)->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("jerk_plan_ns", jerk_plan)->Repetitions(kRepetitions);
  vdrive::test::FigureReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  benchmark::Shutdown();
  return reporter.failed() ? 1 : 0;
}

// SPDX-License-Identifier: Apache-2.0
// The commands home, velocity, torque and jog.
#include "execution/executor.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;

/// @return whether Enter was pressed, or standard input has ended.
bool is_enter_pressed() {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  if (poll(&input, 1, 0) <= 0) return false;
  std::array<char, 64> text{};
  // At the end of the input, too, the jog is no longer held.
  return read(STDIN_FILENO, text.data(), text.size()) >= 0;
}

/// How long a jog is held: a drive time, or until Enter is pressed.
class JogHold {
 public:
  explicit JogHold(std::optional<std::uint64_t> ticks) : ticks_(ticks) {}

  [[nodiscard]] bool is_held(const client::AxisSnapshot& axis) {
    if (!first_) first_ = axis.driven_tick();
    return ticks_ ? axis.driven_tick() < *first_ + *ticks_ : !is_enter_pressed();
  }

 private:
  std::optional<std::uint64_t> ticks_;
  std::optional<std::uint64_t> first_;
};

}  // namespace

client::VelocityOptions Executor::ramps(const client::Axis& axis, const RunRamps& ramps,
                                        client::Until until) const {
  client::VelocityOptions options;
  options.acceleration = limit(axis, ramps.acceleration);
  options.deceleration = limit(axis, ramps.deceleration);
  options.call = call_options(until);
  return options;
}

Outcome Executor::run(const HomeCommand& command) {
  auto axis = axis_to_command(command.axis, command.take_over);
  if (!axis) return axis.outcome();
  client::HomingOptions options;
  options.method = command.method;
  if (command.offset) {
    options.offset = static_cast<std::int32_t>(user_units(*axis, *command.offset));
  }
  options.search_speed = limit(*axis, command.search_speed);
  options.creep_speed = limit(*axis, command.creep_speed);
  options.acceleration = limit(*axis, command.acceleration);
  options.call = call_options(command.until);
  return report_motion(*axis, "home", axis->home(options), command.until == client::Until::done);
}

Outcome Executor::run(const VelocityCommand& command) {
  auto axis = axis_to_command(command.axis, command.take_over);
  if (!axis) return axis.outcome();
  const auto velocity = static_cast<std::int32_t>(user_units(*axis, command.velocity));
  return report_motion(*axis, "velocity",
                       axis->run_at(velocity, ramps(*axis, command.ramps, command.until)), false);
}

Outcome Executor::run(const TorqueCommand& command) {
  auto axis = axis_to_command(command.axis, command.take_over);
  if (!axis) return axis.outcome();
  client::TorqueOptions options;
  options.slope = command.slope;
  options.call = call_options(command.until);
  return report_motion(*axis, "torque", axis->apply_torque(command.torque, options), false);
}

Outcome Executor::run(const JogCommand& command) {
  auto axis = axis_to_command(command.axis, command.take_over);
  if (!axis) return axis.outcome();
  const auto velocity = static_cast<std::int32_t>(user_units(*axis, command.velocity));
  std::optional<std::uint64_t> ticks;
  if (command.duration) {
    const auto bench = bench_of(axis->id());
    if (!bench) return bench.outcome();
    ticks = client::ticks_of(*command.duration, bench->period);
  } else if (!is_quiet_) {
    terminal_.complain("vdrive: Enter or Ctrl-C stops the axis");
  }
  JogHold hold(ticks);
  const Outcome jogged = axis->jog(
      velocity,
      [&hold](const client::AxisSnapshot& seen) {
        return hold.is_held(seen);
      },
      ramps(*axis, command.ramps, client::Until::done));
  if (jogged && session_.is_interrupted()) {
    terminal_.complain("vdrive: interrupted; axis " + label_of(axis->id()) + " stands");
  }
  return report_motion(*axis, "jog", jogged, true);
}

void Executor::check_values(const client::Axis& axis, const HomeCommand& home) const {
  if (home.offset) static_cast<void>(user_units(axis, *home.offset));
  static_cast<void>(limit(axis, home.search_speed));
  static_cast<void>(limit(axis, home.creep_speed));
  static_cast<void>(limit(axis, home.acceleration));
}

void Executor::check_values(const client::Axis& axis, const VelocityCommand& velocity) const {
  static_cast<void>(user_units(axis, velocity.velocity));
  static_cast<void>(ramps(axis, velocity.ramps, velocity.until));
}

void Executor::check_values(const client::Axis& axis, const JogCommand& jog) const {
  static_cast<void>(user_units(axis, jog.velocity));
  static_cast<void>(ramps(axis, jog.ramps, client::Until::done));
}

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
//
// Co-simulation in lock-step: this program is the load. In each tick it reads the position of the
// axis, computes the torque of a pendulum on its shaft, and feeds it back (5E00h). Time passes only
// when the program steps the clock, so every run is the same.
//
//   vdrived --clock lockstep &
//   04_cosimulation [domain]
#include <vdrive/client.hpp>

#include <cmath>
#include <iostream>
#include <numbers>
#include <string>

using namespace vdrive::client;

namespace {

constexpr vdrive::ObjectAddress kTestLoadTorque{0x5E00, 0};  // [mN.m]
constexpr double kUnitsPerRevolution = 4096.0;

/// A point mass on a massless rod, hanging down at position 0.
struct Pendulum {
  double mass = 0.5;    // [kg]
  double length = 0.2;  // [m]

  /// Gravitational torque on the shaft [mN.m]; a positive value accelerates in the positive
  /// direction.
  [[nodiscard]] std::int64_t torque_at(double position) const {
    constexpr double kGravity = 9.81;
    const double angle = 2.0 * std::numbers::pi * position / kUnitsPerRevolution;
    return std::llround(-1000.0 * mass * kGravity * length * std::sin(angle));
  }
};

/// @return the ticks until the axis shows target reached; -1 if something went wrong.
long follow(Axis& axis, Follower& ticks, const Pendulum& pendulum) {
  constexpr std::uint16_t kTargetReached = 1U << 10U;
  for (long tick = 1; tick <= 20'000; ++tick) {
    const auto seen = ticks.next(std::chrono::seconds(1));  // steps the bench by one tick
    if (!seen) {
      std::cerr << seen.outcome().message() << '\n';
      return -1;
    }
    const AxisSnapshot& now = seen->axes.front();
    if (tick > 1 && now.shows(kTargetReached)) return tick;
    const auto written =
        axis.write(kTestLoadTorque, pendulum.torque_at(now.status.load_position_actual_value));
    if (!written) {
      std::cerr << written.outcome().message() << '\n';
      return -1;
    }
  }
  std::cerr << "the pendulum did not come to rest\n";
  return -1;
}

}  // namespace

int main(int argc, char** argv) {
  SessionOptions options;
  if (argc > 1) options.domain = static_cast<std::uint32_t>(std::stoul(argv[1]));
  Session session(options);

  auto axis = session.axis("1.1");
  if (!axis) {
    std::cerr << axis.outcome().message() << '\n';
    return 1;
  }
  auto ticks = session.follow({axis->id()}, Pace::drive);
  if (!ticks || !axis->enable()) {
    std::cerr << "the bench is not there or the axis cannot be enabled\n";
    return 1;
  }

  const Pendulum pendulum;
  for (const double degrees : {90.0, 180.0}) {
    const auto target = static_cast<std::int32_t>(degrees / 360.0 * kUnitsPerRevolution);
    MoveOptions move{.velocity = 4096, .acceleration = 16'384, .deceleration = 16'384, .call = {}};
    move.call.until = Until::in_force;  // follow() waits, not the call
    if (const Outcome started = axis->move_to(target, move); !started) {
      std::cerr << started.message() << '\n';
      return 1;
    }
    const long needed = follow(*axis, *ticks, pendulum);
    if (needed < 0) return 1;
    const auto status = axis->status();
    std::cout << degrees << " degrees after " << needed << " ms, held with "
              << status->status.torque_actual_value / 10.0 << " % of the rated torque against "
              << pendulum.torque_at(target) << " mN.m\n";
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
//
// A master of your own: it plans the positions itself and sends them ahead, each for the tick in
// which it takes effect (cyclic synchronous position, 6060h = 8). No call waits for an answer; the
// status shows the effect of the set-points.
//
//   vdrived --clock lockstep &
//   07_set_points [domain]
#include <vdrive/client.hpp>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

using namespace vdrive::client;

namespace {

constexpr int kTicks = 2000;          // of 1 ms
constexpr int kAhead = 100;           // sent at a time; a bench keeps 1,024, up to 10 s ahead
constexpr double kDistance = 4096.0;  // [UU]

/// A smooth motion over kDistance, at rest at both ends.
std::int32_t offset_at(int tick) {
  const double phase = std::numbers::pi * tick / kTicks;
  return static_cast<std::int32_t>(std::lround(kDistance * (1.0 - std::cos(phase)) / 2.0));
}

/// Changes the mode while the axis is at rest; the set-points then start from its position.
void begin_following(Session& session, Axis& axis) {
  const SetPointFrame mode{.axes = {{.axis = axis.id().axis,
                                     .mode = vdrive::OperatingMode::cyclic_synchronous_position}}};
  session.send_set_points(axis.id().bench, {&mode, 1}).or_throw();
  const auto follows = axis.wait_until(
      [](const AxisSnapshot& seen) {
        return seen.mode() == vdrive::OperatingMode::cyclic_synchronous_position;
      },
      std::chrono::seconds(1));
  follows.outcome().or_throw();
}

/// @return the number of ticks in which the demand (6062h) was not the position sent for it.
int follow(Session& session, Axis& axis) {
  const AxisSnapshot start = axis.status().value();
  const std::int32_t from = start.status.position_demand_value;
  Follower ticks = session.follow({axis.id()}, Pace::drive).value();
  int missed = 0;
  for (int sent = 0; sent < kTicks; sent += kAhead) {
    std::vector<SetPointFrame> frames;
    for (int next = sent + 1; next <= sent + kAhead; ++next) {
      frames.push_back({.tick = start.tick + static_cast<std::uint64_t>(next),
                        .axes = {{.axis = axis.id().axis, .position = from + offset_at(next)}}});
    }
    session.send_set_points(axis.id().bench, frames).or_throw();
    for (int next = sent + 1; next <= sent + kAhead; ++next) {
      // Steps the bench by one tick.
      const Observation seen = ticks.next(std::chrono::seconds(10)).value();
      const std::int32_t demand = seen.axes.front().status.position_demand_value;
      if (demand != from + offset_at(next)) ++missed;
    }
  }
  return missed;
}

}  // namespace

int main(int argc, char** argv) {
  SessionOptions options;
  if (argc > 1) options.domain = static_cast<std::uint32_t>(std::stoul(argv[1]));
  try {
    Session session(options);
    Axis axis = session.axis("1.1").value();
    axis.enable().or_throw();
    begin_following(session, axis);
    const int missed = follow(session, axis);
    session.wait(axis.id().bench, std::chrono::milliseconds(200)).outcome().or_throw();
    std::cout << kTicks << " set-points, " << missed << " not followed, at "
              << axis.status().value().status.load_position_actual_value << '\n';
    axis.disable().or_throw();
    return missed == 0 ? 0 : 1;
  } catch (const std::exception& error) {  // an OutcomeError, or a session that cannot be set up
    std::cerr << error.what() << '\n';
    return 1;
  }
}

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::churn {

using Json = nlohmann::ordered_json;

/// The settings of all roles.
struct Setting {
  client::SessionOptions network;
  std::uint32_t bench = 1;
};

/// A range of axis numbers, both ends included; empty if `last` is below `first`.
struct AxisRange {
  std::uint16_t first = 1;
  std::uint16_t last = 0;

  [[nodiscard]] bool contains(std::uint16_t axis) const noexcept {
    return axis >= first && axis <= last;
  }
};

/// Velocity of the axes in steady motion [UU/s]: 4 UU per tick of 1 ms.
inline constexpr std::int32_t kSteadySpeed = 4000;

/// A relative move of a visitor [UU]: far more than the deviation of an axis at rest from its
/// target, so that a position yields the number of moves.
inline constexpr std::int32_t kStep = 16;

/// The object that stores the stamps: 6067h, position window [UU]. It affects no demand.
inline constexpr ObjectAddress kStampObject{0x6067, 0};

/// @return whether the role should end because standard input was closed.
[[nodiscard]] bool is_stop_requested();

/// Prints a JSON object as one line on standard output, adding `time` in seconds of the monotonic
/// clock.
void print_line(Json line);

/// Prints a failed call.
void print_failure(const std::string& call, const client::Outcome& outcome);

/// Prints the pauses of 5 ms and more between regular events.
class Pauses {
 public:
  /// Notes an event.
  /// @return true ten times a second, when progress should be printed.
  bool note();

 private:
  std::chrono::steady_clock::time_point last_{};
  std::chrono::steady_clock::time_point told_{};
};

/// Options for a fast and short move: a step takes 18 ms.
[[nodiscard]] client::MoveOptions quick(client::Until until);

/// Acquires the axis, resets its fault, enables it and moves it to the nearest multiple of kStep.
/// @return that position, the base of the relative moves that follow.
client::Result<std::int32_t> prepare(client::Axis& axis);

/// Waits until the demand is at rest.
/// @return 6062h [UU]
client::Result<std::int32_t> resting_demand(const client::Axis& axis);

// The roles. Each returns its exit code.

/// Moves the axes of the range at kSteadySpeed for more than an hour, and releases them.
int start(const Setting& setting, AxisRange range);

/// Follows all axes of the bench until it is stopped.
int observe(const Setting& setting, AxisRange steady);

/// The plan of one visitor: join, command one axis for a while, leave.
struct Visit {
  std::uint16_t axis = 1;
  std::chrono::milliseconds duration{200};
  std::int64_t stamp = 0;  ///< the first stamp is one higher
};

int visit(const Setting& setting, const Visit& plan);

/// Reads one object of one axis.
int read(const Setting& setting, std::uint16_t axis, std::uint16_t index);

// Roles that run while wires are killed, until they are stopped.

int motion(const Setting& setting, AxisRange range);
int stream(const Setting& setting, AxisRange range, std::chrono::milliseconds lead);
int group(const Setting& setting, const std::vector<std::string>& axes);
int store(const Setting& setting, AxisRange range);
int step(const Setting& setting);

}  // namespace vdrive::churn

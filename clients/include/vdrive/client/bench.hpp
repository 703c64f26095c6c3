// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/clock_mode.hpp"
#include "vdrive/unit.hpp"

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::client {

using vdrive::ClockMode;
using vdrive::from_user_units;
using vdrive::to_string;
using vdrive::to_user_units;
using vdrive::Unit;
using vdrive::UnitKind;

/// Maximum number of axes of one bench in a frame of set-points or in a group.
inline constexpr std::size_t kMostAxesAtOnce = 256;

/// Maximum number of objects that Axis::read() reads in one tick.
inline constexpr std::size_t kMostObjectsAtOnce = 64;

/// Address of an axis, written `bench.axis`.
struct AxisId {
  std::uint32_t bench = 0;
  std::uint16_t axis = 0;  ///< number on its bench, from 1

  friend auto operator<=>(const AxisId&, const AxisId&) = default;
};

/// @return the address, such as "1.2".
[[nodiscard]] std::string to_string(const AxisId& id);

/// @return the address if `text` has the form `bench.axis`, otherwise nothing: it may be a name.
[[nodiscard]] std::optional<AxisId> parse_axis_id(std::string_view text) noexcept;

/// The description of an axis that its bench publishes.
struct AxisInfo {
  AxisId id;
  std::string name;
  std::uint32_t supported_drive_modes = 0;     ///< 6502h
  std::int32_t user_position_lower_limit = 0;  ///< 607Dh:01 at power-up [UU]
  std::int32_t user_position_upper_limit = 0;  ///< 607Dh:02 at power-up [UU]
  std::uint32_t app_speed_limit = 0;           ///< 607Fh at power-up [UU/s]
  Unit unit;  ///< user units of the axis; for conversions see vdrive/unit.hpp

  friend bool operator==(const AxisInfo&, const AxisInfo&) = default;
};

/// A number that a bench counts or measures from its start. The texts are string constants.
struct Figure {
  std::string_view name;  ///< the name of the member of bench_state
  std::uint64_t value = 0;
  std::string_view unit;  ///< such as "us"; empty = none
  std::string_view help;
  bool is_counter = false;   ///< it only increases
  bool is_headline = false;  ///< for views with room for only a few

  friend bool operator==(const Figure&, const Figure&) = default;
};

/// @return every figure that benches publish, in the order of bench_state, with the value 0.
[[nodiscard]] std::vector<Figure> all_figures();

/// The description that a bench publishes of itself. UU are its user units.
struct BenchInfo {
  std::uint32_t number = 0;
  std::uint64_t incarnation = 0;  ///< of the service; changes with every restart
  std::string name;
  ClockMode clock_mode = ClockMode::realtime;
  std::chrono::microseconds period{1000};  ///< of one tick, in drive time
  /// The status stream has one sample every n ticks; in freerun, one per millisecond of wall time.
  std::uint32_t status_every_ticks = 1;
  std::uint64_t tick = 0;  ///< newest one received
  /// Age of its newest sample of any kind at the time of this description, in wall time. Even a
  /// bench whose time stands still sends its state 20 times a second.
  std::chrono::nanoseconds sample_age{0};
  double rate = 1.0;  ///< realtime: drive time over wall time, 0 = paused
  /// Counters and measurements; 0 = not received yet.
  std::vector<Figure> figures = all_figures();
  /// Starts of its wire process in this run: 1 = never restarted, 0 = not received yet.
  std::uint64_t wire_starts = 0;
  /// Longest time without a message from an owner of axes, in drive time.
  std::chrono::microseconds longest_silence{0};
  double user_units_per_revolution = 4096.0;
  std::string dictionary_version;
  std::string service_version;
  /// Name of the machine or container that its service runs on; empty = unknown, or this process.
  std::string host;
  std::vector<AxisInfo> axes;
};

/// @return `duration` in ticks of `period`, rounded up; 0 for a duration of 0 or less.
[[nodiscard]] std::uint64_t ticks_of(std::chrono::nanoseconds duration,
                                     std::chrono::microseconds period) noexcept;

}  // namespace vdrive::client

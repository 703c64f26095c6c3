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

/// Axes of one bench that one frame of set-points or one group can have.
inline constexpr std::size_t kMostAxesAtOnce = 256;

/// Objects of an axis that are read in one tick.
inline constexpr std::size_t kMostObjectsAtOnce = 64;

/// Address of an axis, written `bench.axis`.
struct AxisId {
  std::uint32_t bench = 0;
  std::uint16_t axis = 0;  ///< number on its bench, from 1

  friend auto operator<=>(const AxisId&, const AxisId&) = default;
};

/// @return such as "1.2".
[[nodiscard]] std::string to_string(const AxisId& id);

/// @return the address when `text` has the form `bench.axis`, else nothing: it may be a name.
[[nodiscard]] std::optional<AxisId> parse_axis_id(std::string_view text) noexcept;

/// What a bench publishes about one of its axes.
struct AxisInfo {
  AxisId id;
  std::string name;
  std::uint32_t supported_drive_modes = 0;     ///< 6502h
  std::int32_t user_position_lower_limit = 0;  ///< 607Dh:01 at power-up [UU]
  std::int32_t user_position_upper_limit = 0;  ///< 607Dh:02 at power-up [UU]
  std::uint32_t app_speed_limit = 0;           ///< 607Fh at power-up [UU/s]
  Unit unit;  ///< what its user units are; the conversions: vdrive/unit.hpp

  friend bool operator==(const AxisInfo&, const AxisInfo&) = default;
};

/// A number that a bench counts or measures from its start on; its texts are constants.
struct Figure {
  std::string_view name;  ///< that of the member of bench_state
  std::uint64_t value = 0;
  std::string_view unit;  ///< such as "us"; empty = none
  std::string_view help;
  bool is_counter = false;   ///< it only grows
  bool is_headline = false;  ///< for views that have room for a few

  friend bool operator==(const Figure&, const Figure&) = default;
};

/// @return every figure that benches publish, in the order of bench_state, with the value 0.
[[nodiscard]] std::vector<Figure> all_figures();

/// What a bench publishes about itself. UU are its user units.
struct BenchInfo {
  std::uint32_t number = 0;
  std::uint64_t incarnation = 0;  ///< of the service; another one after a restart
  std::string name;
  ClockMode clock_mode = ClockMode::realtime;
  std::chrono::microseconds period{1000};  ///< of one tick, in drive time
  /// One sample of the status stream each n ticks; in freerun one each millisecond of wall time.
  std::uint32_t status_every_ticks = 1;
  std::uint64_t tick = 0;  ///< newest one received
  /// Of its newest sample, whatever it carried, when this was found, in wall time. A bench whose
  /// time stands still sends its state 20 times a second.
  std::chrono::nanoseconds sample_age{0};
  double rate = 1.0;  ///< realtime: drive time over wall time, 0 = paused
  /// What it has counted and measured; 0 = not received yet.
  std::vector<Figure> figures = all_figures();
  /// Starts of its network process in this run: 1 = it never ended, 0 = not received yet.
  std::uint64_t wire_starts = 0;
  /// Longest time in which it received nothing from an owner of axes, in drive time.
  std::chrono::microseconds longest_silence{0};
  double user_units_per_revolution = 4096.0;
  std::string dictionary_version;
  std::string service_version;
  /// Name of the machine or container that its service runs on; empty = not known, or this process.
  std::string host;
  std::vector<AxisInfo> axes;
};

/// @return `duration` in ticks of `period`, rounded up; 0 for a duration below or at 0.
[[nodiscard]] std::uint64_t ticks_of(std::chrono::nanoseconds duration,
                                     std::chrono::microseconds period) noexcept;

}  // namespace vdrive::client

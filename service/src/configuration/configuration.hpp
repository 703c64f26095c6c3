// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/wall_step_policy.hpp"
#include "settings/configuration_error.hpp"
#include "vdrive/axis_configuration.hpp"
#include "vdrive/clock_mode.hpp"
#include "vdrive/unit.hpp"
#include "vdrive/wire/participant.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::service {

using settings::ConfigurationError;
using vdrive::ClockMode;
using vdrive::to_string;

inline constexpr std::size_t kMaxAxes = 16'384;

/// How many numbers an axis may have: 0 is none.
inline constexpr std::size_t kAxisNumbers = 65'536;
inline constexpr std::size_t kMaxNameLength = 64;
inline constexpr std::uint32_t kMaxThreads = 64;
inline constexpr std::uint32_t kMaxSteppers = 64;
inline constexpr std::uint32_t kMaxStatusEvery = 10'000;
inline constexpr double kLowestRate = 0.1;
inline constexpr double kHighestRate = 100.0;
inline constexpr std::chrono::milliseconds kShortestWatchdog{5};
inline constexpr std::chrono::milliseconds kLongestWatchdog{10'000};

/// One axis of a bench.
struct NamedAxis {
  std::uint16_t number = 0;  ///< on its bench, from 1
  std::string name;
  Unit unit;  ///< of its user units, for programs and people; the drive does not use it
  AxisConfiguration configuration;
  std::vector<std::string> warnings{};  ///< of its file: see axis_warnings
};

/// Where the wire runs: everything that names DDS.
enum class WireForm : std::uint8_t {
  process,  ///< a separate process: the engine outlives it and restarts it
  thread,   ///< threads of the service: one hop less, but its failure ends the service
};

[[nodiscard]] constexpr std::string_view to_string(WireForm form) noexcept {
  return form == WireForm::process ? "process" : "thread";
}

/// @return the form of that name, or nothing.
[[nodiscard]] std::optional<WireForm> wire_form_named(std::string_view name) noexcept;

/// Everything that makes one service what it is. The initialisers are the defaults; the axes of
/// the built-in demo bench come from `demo_configuration`.
struct Configuration {
  std::uint32_t bench = 1;  ///< 1 to wire::kHighestBench
  std::string name = "demo";
  ClockMode clock = ClockMode::realtime;
  WallStepPolicy clock_step = WallStepPolicy::steer;  ///< realtime
  std::chrono::microseconds period{1'000};            ///< kShortestPeriod to kLongestPeriod
  double rate = 1.0;  ///< realtime: 0 = paused, or kLowestRate to kHighestRate
  /// lock-step: time stands until so many programs have joined the clock, 0 to kMaxSteppers; 0 =
  /// none is awaited
  std::uint32_t steppers = 0;
  std::uint32_t threads = 1;       ///< that step the bank
  int realtime_priority = 0;       ///< SCHED_FIFO of the tick thread, 0 = none
  std::uint32_t status_every = 1;  ///< one status frame each n ticks
  /// The owner of an axis must send something within this drive time; nothing = off.
  std::optional<std::chrono::milliseconds> watchdog = std::chrono::milliseconds{500};
  bool watchdog_is_chosen = false;            ///< in freerun a watchdog that was not chosen is off
  std::string metrics_address = "127.0.0.1";  ///< of this machine, IPv4
  /// Prometheus metrics on this port of that address, 0 = any free one; nothing = off.
  std::optional<std::uint16_t> metrics_port;
  std::optional<WireForm> wire_form;          ///< nothing = see `effective_wire_form`
  std::uint32_t wire_memory_limit_mib = 512;  ///< of its process
  std::uint32_t black_box_memory_mib = 64;    ///< of what the bench keeps of the last minutes
  wire::NetworkSettings network;
  std::vector<NamedAxis> axes;  ///< 1 to kMaxAxes, in ascending order of their numbers
};

/// @return bench 1 with the default axes 1 ("x") and 2 ("y").
[[nodiscard]] Configuration demo_configuration();

/// @return `count` default axes numbered from 1, named "axis1" and so on.
/// @throws ConfigurationError when `count` is outside 1 to kMaxAxes.
[[nodiscard]] std::vector<NamedAxis> default_axes(std::size_t count);

/// Of every configuration, once flags and options have changed it.
/// @throws ConfigurationError when a value is outside the limits above.
void check(const Configuration& configuration);

/// @param key of the section `clock`
/// @return which mode has no use for the key, such as "lockstep, which advances only when programs
/// step it";
///         nothing where it has.
[[nodiscard]] std::optional<std::string> problem_of_clock(std::string_view key,
                                                          const Configuration& configuration);

/// @return the watchdog in effect; nothing = off.
[[nodiscard]] std::optional<std::chrono::milliseconds> effective_watchdog(
    const Configuration& configuration) noexcept;

/// @return the form of the wire in effect. The default: threads in lock-step and freerun where only
///         programs of this host without credentials take part, and with shared memory; otherwise a
///         process.
[[nodiscard]] WireForm effective_wire_form(const Configuration& configuration) noexcept;

/// @return the number after the highest of the axes.
[[nodiscard]] std::size_t end_of_numbers(const Configuration& configuration) noexcept;

/// @return the axes as the bank wants them, with their serial numbers.
[[nodiscard]] std::vector<AxisConfiguration> bank_axes(const Configuration& configuration);

}  // namespace vdrive::service

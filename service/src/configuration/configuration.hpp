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

/// The number of axis numbers, including 0, which no axis has.
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
  Unit unit;  ///< in which programs show positions; the drive does not use it
  AxisConfiguration configuration;
  std::vector<std::string> warnings{};  ///< found when its file was read, see axis_warnings
};

/// Where the wire runs. The wire is the part of the service that handles DDS.
enum class WireForm : std::uint8_t {
  process,  ///< in a separate process: the engine survives its failure and restarts it
  thread,   ///< in threads of the service: one hop fewer, but its failure ends the service
};

[[nodiscard]] constexpr std::string_view to_string(WireForm form) noexcept {
  return form == WireForm::process ? "process" : "thread";
}

/// @return the form with this name, or nullopt.
[[nodiscard]] std::optional<WireForm> wire_form_named(std::string_view name) noexcept;

/// The complete configuration of a service. The initialisers are the defaults; the axes of the
/// built-in demo bench come from `demo_configuration`.
struct Configuration {
  std::uint32_t bench = 1;  ///< 1 to wire::kHighestBench
  std::string name = "demo";
  ClockMode clock = ClockMode::realtime;
  WallStepPolicy clock_step = WallStepPolicy::steer;  ///< realtime
  std::chrono::microseconds period{1'000};            ///< kShortestPeriod to kLongestPeriod
  double rate = 1.0;  ///< realtime: 0 = paused, or kLowestRate to kHighestRate
  /// lock-step: time stands still until this many programs have joined the clock, 0 to kMaxSteppers
  std::uint32_t steppers = 0;
  std::uint32_t threads = 1;       ///< that step the bank
  int realtime_priority = 0;       ///< SCHED_FIFO priority of the tick thread, 0 = none
  std::uint32_t status_every = 1;  ///< one status frame every n ticks
  /// The owner of an axis must send something within this drive time; nullopt = off.
  std::optional<std::chrono::milliseconds> watchdog = std::chrono::milliseconds{500};
  bool watchdog_is_chosen = false;            ///< set explicitly; if not, freerun has no watchdog
  std::string metrics_address = "127.0.0.1";  ///< of this machine, IPv4
  /// Prometheus metrics on this port of that address, 0 = any free one; nullopt = off.
  std::optional<std::uint16_t> metrics_port;
  std::optional<WireForm> wire_form;          ///< nullopt = see `effective_wire_form`
  std::uint32_t wire_memory_limit_mib = 512;  ///< of the wire's process
  std::uint32_t black_box_memory_mib = 64;    ///< for the record of the last minutes
  wire::NetworkSettings network;
  std::vector<NamedAxis> axes;  ///< 1 to kMaxAxes, in ascending order of their numbers
};

/// @return bench 1 with the default axes 1 ("x") and 2 ("y").
[[nodiscard]] Configuration demo_configuration();

/// @return `count` default axes numbered from 1, named "axis1" and so on.
/// @throws ConfigurationError if `count` is outside 1 to kMaxAxes
[[nodiscard]] std::vector<NamedAxis> default_axes(std::size_t count);

/// Checks a configuration after command-line options have changed it.
/// @throws ConfigurationError if a value is outside the limits above, or if a wire in a separate
///         process would have to use shared memory
void check(const Configuration& configuration);

/// @param key of the section `clock`
/// @return nullopt if the key has a meaning in the present clock mode; otherwise a description of
///         that mode for the message, such as "lockstep, which advances only when programs step
///         it".
[[nodiscard]] std::optional<std::string> problem_of_clock(std::string_view key,
                                                          const Configuration& configuration);

/// @return the watchdog in effect; nullopt = off.
[[nodiscard]] std::optional<std::chrono::milliseconds> effective_watchdog(
    const Configuration& configuration) noexcept;

/// @return the form of the wire in effect. The default is threads if shared memory is on, or in
///         lock-step and freerun if only programs of this host take part and none needs
///         credentials. Otherwise it is a process.
[[nodiscard]] WireForm effective_wire_form(const Configuration& configuration) noexcept;

/// @return the highest axis number plus 1.
[[nodiscard]] std::size_t end_of_numbers(const Configuration& configuration) noexcept;

/// @return the axes as the bank needs them, with their serial numbers.
[[nodiscard]] std::vector<AxisConfiguration> bank_axes(const Configuration& configuration);

}  // namespace vdrive::service

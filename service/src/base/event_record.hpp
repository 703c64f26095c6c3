// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/parameter_problem.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <cstdint>
#include <string>
#include <type_traits>
#include <variant>

namespace vdrive::service {

/// How many: axes, ticks, set-points, messages.
struct Count {
  std::uint64_t value = 0;

  friend bool operator==(const Count&, const Count&) = default;
};

/// Axes whose owner sent nothing to the bench in time.
struct LostAxes {
  std::uint64_t count = 0;
  std::uint64_t silence_ms = 0;  ///< of the owner, in drive time

  friend bool operator==(const LostAxes&, const LostAxes&) = default;
};

/// Ticks that ended too late.
struct Overruns {
  std::uint64_t count = 0;
  std::chrono::microseconds worst{0};
  std::chrono::milliseconds span{0};  ///< from the first of them on

  friend bool operator==(const Overruns&, const Overruns&) = default;
};

/// A number that names something: a snapshot, an incarnation.
struct Label {
  std::uint64_t value = 0;

  friend bool operator==(const Label&, const Label&) = default;
};

/// A request or a command frame that was refused.
struct RefusedMessage {
  std::uint64_t number = 0;   ///< of the request or the frame
  std::uint64_t late_by = 0;  ///< [ticks] since the one that the frame was meant for

  friend bool operator==(const RefusedMessage&, const RefusedMessage&) = default;
};

/// Drive time over wall time.
struct NewRate {
  double value = 1.0;

  friend bool operator==(const NewRate&, const NewRate&) = default;
};

/// Why a stepper is no longer one.
enum class Parting : std::uint8_t {
  left,    ///< it left by request
  silent,  ///< nothing arrived from it while others waited
  gone,    ///< its participant left the network
};

/// What an operation of the system answered: an errno.
struct SystemError {
  int number = 0;

  /// @return such as "No space left on device".
  [[nodiscard]] std::string text() const;

  friend bool operator==(const SystemError&, const SystemError&) = default;
};

/// What is wrong with stored parameters.
struct StoredProblem {
  ParameterProblem problem = ParameterProblem::none;
  std::uint64_t number = 0;  ///< see ParameterProblem

  /// @return such as "damaged".
  [[nodiscard]] std::string text() const;

  friend bool operator==(const StoredProblem&, const StoredProblem&) = default;
};

/// Why a wire is gone.
struct WireLoss {
  enum class Cause : std::uint8_t {
    signal,     ///< value: its number
    exit_code,  ///< value: the code
    no_start,   ///< it did not come up in time
    hangs,      ///< its pumps made no round
    deaf,       ///< no probe came through discovery and data
    memory,     ///< value: what it used [MiB]
  };

  Cause cause = Cause::signal;
  std::uint32_t value = 0;

  /// @return such as "signal 6 (Aborted)".
  [[nodiscard]] std::string text() const;

  friend bool operator==(const WireLoss&, const WireLoss&) = default;
};

/// What an event contains beside its axis, session and code:
///
/// | event | detail |
/// | --- | --- |
/// | refused | RefusedMessage |
/// | set-point ignored, control changed, tick jumped, queue overflow | Count |
/// | master lost | LostAxes |
/// | tick overrun | Overruns |
/// | wall clock | how far the wall clock is ahead of drive time |
/// | clock changed | NewRate, or why a stepper left: Parting |
/// | snapshot, bench conflict | Label |
/// | stopped | Label of the owner's session |
/// | journal | Count of lost ticks, or SystemError |
/// | parameters | Count of axes, StoredProblem, or SystemError |
/// | wire | WireLoss, or the time without one, or until the next one |
/// | any other | nothing |
using EventDetail =
    std::variant<std::monostate, Count, LostAxes, Overruns, Label, RefusedMessage, NewRate, Parting,
                 SystemError, StoredProblem, WireLoss, std::chrono::microseconds>;

/// Something to report, before it becomes text.
struct EventRecord {
  msg::EventKind kind{};
  std::uint16_t axis = 0;  ///< number on the bench, 0 = the bench
  std::uint64_t session = 0;
  std::uint32_t code = 0;
  std::uint8_t error_register = 0;
  std::uint64_t tick = 0;
  EventDetail detail{};
};

static_assert(std::is_trivially_copyable_v<EventRecord>, "the thread that ticks copies it");

}  // namespace vdrive::service

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

/// A number of axes, ticks, set-points or messages.
struct Count {
  std::uint64_t value = 0;

  friend bool operator==(const Count&, const Count&) = default;
};

/// Axes whose owner was silent for too long.
struct LostAxes {
  std::uint64_t count = 0;
  std::uint64_t silence_ms = 0;  ///< of the owner, in drive time

  friend bool operator==(const LostAxes&, const LostAxes&) = default;
};

/// Ticks that ended too late.
struct Overruns {
  std::uint64_t count = 0;
  std::chrono::microseconds worst{0};
  std::chrono::milliseconds span{0};  ///< since the first one

  friend bool operator==(const Overruns&, const Overruns&) = default;
};

/// A number that identifies something: a snapshot, an incarnation, a session.
struct Label {
  std::uint64_t value = 0;

  friend bool operator==(const Label&, const Label&) = default;
};

/// A request or a command frame that was refused.
struct RefusedMessage {
  std::uint64_t number = 0;   ///< of the request or the frame
  std::uint64_t late_by = 0;  ///< ticks since the target tick of the frame

  friend bool operator==(const RefusedMessage&, const RefusedMessage&) = default;
};

/// The ratio of drive time to wall time.
struct NewRate {
  double value = 1.0;

  friend bool operator==(const NewRate&, const NewRate&) = default;
};

/// Why a session stopped being a stepper.
enum class StepperRemoval : std::uint8_t {
  left,    ///< it left by request
  silent,  ///< nothing arrived from it while others waited
  gone,    ///< its participant left the network
};

/// The errno of a failed system call.
struct SystemError {
  int number = 0;

  /// @return for example "No space left on device".
  [[nodiscard]] std::string text() const;

  friend bool operator==(const SystemError&, const SystemError&) = default;
};

struct StoredProblem {
  ParameterProblem problem = ParameterProblem::none;
  std::uint64_t number = 0;  ///< see ParameterProblem

  /// @return for example "damaged".
  [[nodiscard]] std::string text() const;

  friend bool operator==(const StoredProblem&, const StoredProblem&) = default;
};

/// Why a wire ended or was ended.
struct WireLoss {
  enum class Cause : std::uint8_t {
    signal,     ///< value: signal number
    exit_code,  ///< value: exit code
    no_start,   ///< it was not ready in time
    hangs,      ///< its pumps completed no round
    deaf,       ///< it was not discovered, or exchanged no sample, in time (WireProbe)
    memory,     ///< value: memory used [MiB]
  };

  Cause cause = Cause::signal;
  std::uint32_t value = 0;

  /// @return for example "ended by signal 6 (Aborted)".
  [[nodiscard]] std::string text() const;

  friend bool operator==(const WireLoss&, const WireLoss&) = default;
};

/// The content of an event apart from its axis, session and code:
///
/// | event | detail |
/// | --- | --- |
/// | refused | RefusedMessage |
/// | set-point ignored, control changed, tick jumped, queue overflow | Count |
/// | master lost | LostAxes |
/// | tick overrun | Overruns |
/// | wall clock | time by which the wall clock is ahead of drive time |
/// | clock changed | NewRate, or the StepperRemoval |
/// | snapshot, bench conflict | Label |
/// | stopped | Label of the owner's session |
/// | journal | Count of lost ticks, or SystemError |
/// | parameters | Count of axes, StoredProblem, or SystemError |
/// | wire | WireLoss; the time without a wire; or the time until the next start |
/// | any other | none |
using EventDetail =
    std::variant<std::monostate, Count, LostAxes, Overruns, Label, RefusedMessage, NewRate,
                 StepperRemoval, SystemError, StoredProblem, WireLoss, std::chrono::microseconds>;

/// An event before it is formatted as text.
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

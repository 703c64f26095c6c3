// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"
#include "configuration/configuration.hpp"
#include "vdrive/wire/source.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vdrive::service {

/// A session that joined the clock of a lock-step bench.
struct Stepper {
  using Time = std::chrono::steady_clock::time_point;

  std::uint64_t session = 0;
  wire::Source source{};
  std::uint64_t granted = 0;   ///< last tick that it lets pass
  Time last_message{};         ///< when its last message arrived
  bool is_waited_for = false;  ///< another stepper has granted more
  Time waited_for_since{};     ///< valid if `is_waited_for`
  bool was_matched = false;    ///< its participant has been seen on the network
};

/// The sessions that joined the clock of a lock-step bench: time advances to the smallest of their
/// grants. The caller passes the wall time. Not thread-safe.
class StepperTable {
 public:
  using Time = Stepper::Time;

  /// A stepper counts as silent if others have waited for it this long, and it has sent nothing in
  /// that time.
  static constexpr std::chrono::seconds kLongestSilence{10};

  /// @param awaited how many steppers must join before time passes, 0 to kMaxSteppers
  explicit StepperTable(std::size_t awaited = 0) noexcept
      : always_awaited_(awaited), awaited_(awaited) {}

  /// Makes the session (not 0) a stepper whose grant is the present tick. Leaves an existing
  /// stepper unchanged.
  /// @param awaited how many steppers must join before time passes, 0 to kMaxSteppers; in force
  ///        until all have left
  /// @return false if there is no room
  [[nodiscard]] bool join(std::uint64_t session, const wire::Source& source, std::uint64_t tick,
                          Time now, std::size_t awaited = 0);

  /// @return whether the awaited number of steppers has joined. Time then passes, even if some
  ///         leave. When all have left, they are awaited again.
  [[nodiscard]] bool is_complete() const noexcept { return is_complete_; }

  /// @return whether sessions that have not joined may step.
  [[nodiscard]] bool is_open() const noexcept { return steppers_.empty() && always_awaited_ == 0; }

  /// @return false if the session is not a stepper.
  bool leave(std::uint64_t session, Time now);

  /// @return the stepper, or nullptr.
  [[nodiscard]] Stepper* find(std::uint64_t session) noexcept;

  /// Notes that a message of the session, stepper or not, has arrived.
  void note_message(std::uint64_t session, Time now) noexcept;

  /// Lets the stepper grant `ticks` more.
  void grant(Stepper& stepper, std::uint64_t ticks, Time now) noexcept;

  /// @return the stepper that granted the fewest ticks, the first to join if there are several;
  ///         nullptr if there is none.
  [[nodiscard]] const Stepper* slowest() const noexcept;

  /// @return a stepper that is silent, or nullptr.
  [[nodiscard]] const Stepper* silent(Time now) const noexcept;

  [[nodiscard]] std::span<Stepper> all() noexcept { return steppers_; }

  [[nodiscard]] bool empty() const noexcept { return steppers_.empty(); }

  [[nodiscard]] std::size_t size() const noexcept { return steppers_.size(); }

 private:
  void note_waits(Time now) noexcept;

  std::vector<Stepper> steppers_;
  std::size_t always_awaited_;
  std::size_t awaited_;  ///< as required by the bench or by one of its steppers
  bool is_complete_ = false;
};

}  // namespace vdrive::service

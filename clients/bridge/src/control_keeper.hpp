// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "severity.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/outcome.hpp"

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace vdrive::bridge {

/// @return a session other than `own` that controls one of the axes; nothing if there is none.
[[nodiscard]] std::optional<std::uint64_t> other_owner(std::span<const client::AxisSnapshot> axes,
                                                       std::uint64_t own);

/// @return whether this session controls all of the axes.
[[nodiscard]] bool owns_all(std::span<const client::AxisSnapshot> axes, std::uint64_t own);

/// The operations of a ControlKeeper on its bench. Each may wait, except report().
class ControlledBench {
 public:
  virtual ~ControlledBench() = default;

  /// Takes control of all axes, or of none.
  virtual client::Outcome acquire() = 0;

  /// @return the present state of all axes.
  virtual std::optional<client::Observation> observe() = 0;

  /// @return the name of another session for messages.
  virtual std::string name_of(std::uint64_t session) = 0;

  virtual void report(Severity severity, const std::string& text) = 0;
};

/// Advice in reports, in the terms of the protocol that the bridge serves.
struct ControlRemedies {
  std::string loss;    ///< how to regain lost control
  std::string faults;  ///< how to reset faults
};

/// Takes control of all axes of a bench as soon as no other session controls any of them. Control
/// taken by another session is not regained until it is wanted again. Reports once each owner that
/// it waits for. Time is passed as an argument. want() may be called from any thread, keep() only
/// from the thread that may wait for the bench.
class ControlKeeper {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds kRetry{200};
  static constexpr std::chrono::milliseconds kLongestRetry{2000};

  /// @param session that takes control
  /// @param bench must outlive this
  ControlKeeper(std::uint64_t session, ControlledBench& bench, ControlRemedies remedies)
      : session_(session), bench_(bench), remedies_(std::move(remedies)) {}

  /// Sets whether control is wanted from now on. Calling this again after a loss takes control
  /// again.
  void want(bool wanted);

  [[nodiscard]] bool is_wanted() const;

  /// Takes control if that is due. A request is sent only while the status shows no other owner,
  /// because a refusal is an event that all clients of the bench receive.
  /// @param axes the newest state of all axes
  /// @return their state after control was taken; nothing if it was not.
  std::optional<client::Observation> keep(std::span<const client::AxisSnapshot> axes,
                                          Clock::time_point now);

 private:
  /// The reports already made, which are not repeated.
  struct Reported {
    std::uint64_t owner = 0;  ///< session that control waits for; 0 = not waiting
    std::string refusal;
  };

  [[nodiscard]] bool is_due(std::span<const client::AxisSnapshot> axes, Clock::time_point now);
  void note_owner(std::span<const client::AxisSnapshot> axes);
  [[nodiscard]] bool has_just_lost(std::span<const client::AxisSnapshot> axes);
  void wait_for(std::uint64_t owner, std::span<const client::AxisSnapshot> axes);
  void note_refusal(const client::Outcome& refusal, Clock::time_point now);
  void report_taken(std::span<const client::AxisSnapshot> axes);

  const std::uint64_t session_;
  ControlledBench& bench_;
  const ControlRemedies remedies_;
  mutable std::mutex mutex_;  ///< guards the members that want() changes
  bool is_wanted_ = false;
  bool is_new_ = false;  ///< wanted again: repeat earlier reports
  bool had_it_ = false;  ///< has controlled all axes since control was wanted
  bool has_lost_ = false;
  // Used only by the thread of keep().
  Reported reported_;
  Clock::time_point due_{};
  std::chrono::milliseconds retry_{kRetry};
};

}  // namespace vdrive::bridge

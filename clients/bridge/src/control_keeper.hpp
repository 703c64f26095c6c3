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

/// @return a session other than `own` that controls one of the axes; none when there is none.
[[nodiscard]] std::optional<std::uint64_t> other_owner(std::span<const client::AxisSnapshot> axes,
                                                       std::uint64_t own);

/// @return whether this session controls all of the axes.
[[nodiscard]] bool owns_all(std::span<const client::AxisSnapshot> axes, std::uint64_t own);

/// What a ControlKeeper does to its bench. Each call may wait, but report().
class ControlledBench {
 public:
  virtual ~ControlledBench() = default;

  /// Takes control of all axes, or of none.
  virtual client::Outcome acquire() = 0;

  /// @return the state of all axes now.
  virtual std::optional<client::Observation> observe() = 0;

  /// @return how messages call another session.
  virtual std::string name_of(std::uint64_t session) = 0;

  virtual void report(Severity severity, const std::string& text) = 0;
};

/// What reports advise, in the words of the world of a bridge.
struct ControlRemedies {
  std::string loss;    ///< how lost control is taken again
  std::string faults;  ///< how a person resets them
};

/// Takes control of all axes of a bench as soon as no other session controls one of them. Control
/// that another session takes is not taken back before it is wanted once more. Reports each owner
/// that it waits for once. Time is an argument; want() is for any thread, keep() for the one that
/// may wait for the bench.
class ControlKeeper {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds kRetry{200};
  static constexpr std::chrono::milliseconds kLongestRetry{2000};

  /// @param session that takes control
  /// @param bench outlives this
  ControlKeeper(std::uint64_t session, ControlledBench& bench, ControlRemedies remedies)
      : session_(session), bench_(bench), remedies_(std::move(remedies)) {}

  /// Whether control is wanted from now on. Wanted once more after a loss, it is taken again.
  void want(bool wanted);

  [[nodiscard]] bool is_wanted() const;

  /// Does what is due. It sends a request only while the status has no other owner: a refusal is an
  /// event of the bench, which all its clients receive.
  /// @param axes the newest state of all axes
  /// @return their state after control was taken; none when it was not.
  std::optional<client::Observation> keep(std::span<const client::AxisSnapshot> axes,
                                          Clock::time_point now);

 private:
  /// What was reported, and is not reported again.
  struct Reported {
    std::uint64_t owner = 0;  ///< session that control waits for; 0 = it does not wait
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
  mutable std::mutex mutex_;  ///< guards what want() changes
  bool is_wanted_ = false;
  bool is_new_ = false;  ///< wanted once more: what was reported is reported again
  bool had_it_ = false;  ///< all axes, since it is wanted
  bool has_lost_ = false;
  // Of the thread of keep().
  Reported reported_;
  Clock::time_point due_{};
  std::chrono::milliseconds retry_{kRetry};
};

}  // namespace vdrive::bridge

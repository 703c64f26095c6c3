// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "base/reason.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/control_table.hpp"
#include "engine/frame_schedule.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::service {

/// The sessions that control axes: which session owns which axis, and how axes change owners.
class Masters {
 public:
  Masters(BenchAxes& axes, const BenchClock& clock, FrameSchedule& schedule, BenchEvents& events,
          Counters& counters);

  [[nodiscard]] const wire::Ownership& owner(std::size_t axis) const noexcept {
    return control_.owner(axis);
  }

  [[nodiscard]] std::span<const wire::Ownership> owners() const noexcept {
    return control_.owners();
  }

  [[nodiscard]] std::span<SessionRecord> sessions() noexcept { return control_.sessions(); }

  /// @return the record of `session`, or nullptr.
  [[nodiscard]] const SessionRecord* find(std::uint64_t session) const noexcept;

  /// @return the record of `session` (not 0), created if there is none; nullptr if the table is
  ///         full.
  [[nodiscard]] SessionRecord* admit(std::uint64_t session);

  /// Notes that a message of the session has just arrived.
  void note_message(std::uint64_t session);

  /// Notes that a command frame of the owner was applied to the axis.
  void set_applied(std::size_t axis, std::uint64_t sequence) noexcept {
    control_.set_applied(axis, sequence);
  }

  /// Checks that the request names axes, that they exist, and that no other session owns them.
  /// @return REASON_NONE, or why the request is refused; `reply` then names the axis and its owner.
  [[nodiscard]] Reason check_axes(const msg::Request& request, bool owned_by_others_allowed,
                                  msg::Reply& reply) const;

  /// Names the axis with this number, and its owner, as the cause of a refusal. Only the first call
  /// for a reply has an effect.
  void name_refused(std::uint16_t number, msg::Reply& reply) const;

  // Requests of a session other than 0. @return REASON_NONE, or why the request is refused.
  /// REQUEST_ACQUIRE and REQUEST_TAKE_OVER.
  [[nodiscard]] Reason acquire(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] Reason release(const msg::Request& request, msg::Reply& reply);

  /// Gives the free axis to a session that wrote one of its command objects.
  void give(std::size_t axis, SessionRecord& record);

  /// Takes all axes from a session that was silent for `silence` of drive time; the axes react to
  /// the loss of the connection.
  void lose(SessionRecord& record, std::chrono::milliseconds silence);

 private:
  void take_from_owner(std::size_t axis);
  void free_axes(const msg::Request& request);

  BenchAxes& axes_;
  const BenchClock& clock_;
  FrameSchedule& schedule_;
  BenchEvents& events_;
  Counters& counters_;
  ControlTable control_;
};

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#include "engine/masters.hpp"

namespace vdrive::service {

Masters::Masters(BenchAxes& axes, const BenchClock& clock, FrameSchedule& schedule,
                 BenchEvents& events, Counters& counters)
    : axes_(axes),
      clock_(clock),
      schedule_(schedule),
      events_(events),
      counters_(counters),
      control_(axes.size()) {}

const SessionRecord* Masters::find(std::uint64_t session) const noexcept {
  return control_.find(session);
}

SessionRecord* Masters::admit(std::uint64_t session) {
  return control_.find_or_add(session, clock_.tick());
}

void Masters::note_message(std::uint64_t session) {
  if (session == 0) return;
  if (SessionRecord* const record = control_.find(session); record != nullptr) {
    record->last_message_tick = clock_.tick();
  }
}

Reason Masters::check_axes(const msg::Request& request, bool owned_by_others_allowed,
                           msg::Reply& reply) const {
  if (request.axes.empty()) return msg::Reason::nothing_done;
  for (const std::uint16_t number : request.axes) {
    const auto axis = axes_.index_of(number);
    if (!axis) {
      name_refused(number, reply);
      return msg::Reason::unknown_axis;
    }
    const std::uint64_t owner = control_.owner(*axis).session;
    if (!owned_by_others_allowed && owner != 0 && owner != request.session) {
      name_refused(number, reply);
      return AbortCode::refused_local_control;
    }
  }
  return msg::Reason::none;
}

void Masters::name_refused(std::uint16_t number, msg::Reply& reply) const {
  if (reply.refused_axis != 0) return;
  reply.refused_axis = number;
  if (const auto axis = axes_.index_of(number)) reply.owner_session = control_.owner(*axis).session;
}

Reason Masters::acquire(const msg::Request& request, msg::Reply& reply) {
  const bool by_force = request.kind == msg::RequestKind::take_over;
  if (const auto reason = check_axes(request, by_force, reply); reason != msg::Reason::none) {
    return reason;
  }
  SessionRecord* const record = admit(request.session);
  if (record == nullptr) return msg::Reason::queue_full;
  std::size_t gained = 0;
  std::uint16_t last_gained = 0;
  for (const std::uint16_t number : request.axes) {
    const std::size_t axis = axes_.index_of_checked(number);
    if (control_.owner(axis).session != request.session) {
      take_from_owner(axis);
      control_.give(axis, *record);
      ++gained;
      last_gained = number;
    }
  }
  record->last_message_tick = clock_.tick();
  record->must_acquire = false;
  if (gained > 0) {
    control_.renew_epoch(*record);
    events_.report({.kind = msg::EventKind::control_changed,
                    .axis = gained == 1 ? last_gained : std::uint16_t{0},
                    .session = request.session,
                    .code = record->epoch,
                    .detail = Count{gained}});
  }
  return msg::Reason::none;
}

/// Takes the axis from its owner, if any, for another session. The owner gets a new epoch, and its
/// waiting frames are cancelled.
void Masters::take_from_owner(std::size_t axis) {
  SessionRecord* const loser = control_.find(control_.owner(axis).session);
  if (loser == nullptr || control_.owner(axis).session == 0) return;
  control_.take(axis);
  control_.renew_epoch(*loser);
  loser->must_acquire = true;
  schedule_.cancel_of_session(loser->session);
  events_.report({.kind = msg::EventKind::control_changed,
                  .axis = axes_.number_of(axis),
                  .session = loser->session});
}

Reason Masters::release(const msg::Request& request, msg::Reply& reply) {
  SessionRecord* const record = control_.find(request.session);
  if (record == nullptr || record->owned_axes == 0) return msg::Reason::nothing_done;
  for (const std::uint16_t number : request.axes) {
    const auto axis = axes_.index_of(number);
    if (!axis || control_.owner(*axis).session != request.session) {
      name_refused(number, reply);
      if (!axis) return msg::Reason::unknown_axis;
      return msg::Reason::not_owner;
    }
  }
  const std::size_t before = record->owned_axes;
  free_axes(request);
  control_.renew_epoch(*record);
  schedule_.cancel_of_session(request.session);
  events_.report({.kind = msg::EventKind::control_changed,
                  .axis = request.axes.size() == 1 ? request.axes.front() : std::uint16_t{0},
                  .session = request.session,
                  .detail = Count{before - record->owned_axes}});
  return msg::Reason::none;
}

/// Frees the axes in the request, or all axes of its session if it names none.
void Masters::free_axes(const msg::Request& request) {
  for (const std::uint16_t number : request.axes) control_.take(axes_.index_of_checked(number));
  for (std::size_t axis = 0; request.axes.empty() && axis < axes_.size(); ++axis) {
    if (control_.owner(axis).session == request.session) control_.take(axis);
  }
}

void Masters::give(std::size_t axis, SessionRecord& record) {
  control_.give(axis, record);
  control_.renew_epoch(record);
  record.last_message_tick = clock_.tick();
  events_.report({.kind = msg::EventKind::control_changed,
                  .axis = axes_.number_of(axis),
                  .session = record.session,
                  .code = record.epoch,
                  .detail = Count{1}});
}

void Masters::lose(SessionRecord& record, std::chrono::milliseconds silence) {
  std::size_t lost = 0;
  std::uint16_t last_number = 0;
  for (std::size_t axis = 0; axis < axes_.size(); ++axis) {
    if (control_.owner(axis).session == record.session) {
      axes_.lose_connection(axis);
      control_.take(axis);
      last_number = axes_.number_of(axis);
      ++lost;
    }
  }
  control_.renew_epoch(record);
  record.must_acquire = true;
  schedule_.cancel_of_session(record.session);
  counters_.master_losses.add();
  events_.report({.kind = msg::EventKind::master_lost,
                  .axis = lost == 1 ? last_number : std::uint16_t{0},
                  .session = record.session,
                  .code = static_cast<std::uint32_t>(silence.count()),
                  .detail = LostAxes{lost, static_cast<std::uint64_t>(silence.count())}});
}

}  // namespace vdrive::service

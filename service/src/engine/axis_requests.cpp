// SPDX-License-Identifier: Apache-2.0
#include "engine/axis_requests.hpp"

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <limits>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;

constexpr Reason kLocalControl = AbortCode::refused_local_control;

msg::ObjectResult& add_result(const msg::ObjectAccess& object, Reason reason, msg::Reply& reply) {
  auto& result = reply.objects.emplace_back();
  result.axis = object.axis;
  result.index = object.index;
  result.subindex = object.subindex;
  result.abort_code = reason.on_wire();
  result.value = object.value;
  return result;
}

/// The stops that a session may command on an axis that it does not own.
enum class Stop : std::uint8_t { none, quick_stop, halt };

/// @return the stop that the write commands; none if it also commands something else.
Stop stop_in(ObjectRow row, std::int64_t value) {
  constexpr std::int64_t kHighest = std::numeric_limits<std::uint16_t>::max();
  if (row != "ds402_controlword"_object || value < 0 || value > kHighest) return Stop::none;
  const auto word = static_cast<std::uint16_t>(value);
  if ((word & Controlword::kNewSetPoint) != 0) return Stop::none;
  const PowerCommand command = decode_command(word, word);
  if (command == PowerCommand::quick_stop) return Stop::quick_stop;
  const bool halts = (word & Controlword::kHalt) != 0;
  return halts && command == PowerCommand::enable_operation ? Stop::halt : Stop::none;
}

/// @return the reason for a reply whose results are complete.
Reason reason_of(const msg::Reply& reply) {
  const auto& results = reply.objects;
  if (results.empty()) return msg::Reason::nothing_done;
  const bool unknown_axis = std::ranges::any_of(results, [](const auto& result) {
    return result.abort_code == msg::Reason::unknown_axis;
  });
  if (unknown_axis) return msg::Reason::unknown_axis;
  return msg::Reason::none;
}

}  // namespace

AxisRequests::AxisRequests(BenchAxes& axes, AxisWriter& writer, const BenchClock& clock,
                           Masters& masters, FrameSchedule& schedule, StoreRequests& stores,
                           BenchEvents& events)
    : axes_(axes),
      writer_(writer),
      clock_(clock),
      masters_(masters),
      schedule_(schedule),
      stores_(stores),
      events_(events) {}

Reason AxisRequests::read(const msg::Request& request, msg::Reply& reply) const {
  for (const auto& object : request.objects) {
    const auto axis = axes_.index_of(object.axis);
    if (!axis) {
      add_result(object, msg::Reason::unknown_axis, reply).value = 0;
      masters_.name_refused(object.axis, reply);
      continue;
    }
    const ReadResult result = axes_.bank().read(*axis, {object.index, object.subindex});
    add_result(object, result.code, reply).value = result.value;
  }
  return reason_of(reply);
}

Reason AxisRequests::write(const msg::Request& request, msg::Reply& reply) {
  for (const auto& object : request.objects) {
    const Reason reason = write_object(object, request.session, reply.objects.size());
    add_result(object, reason, reply);
    if (const auto axis = axes_.index_of(object.axis); axis && reason != msg::Reason::none) {
      axes_.record_refusal(*axis, {object.index, object.subindex}, object.value, reason);
    }
    if (reason == msg::Reason::unknown_axis || reason == kLocalControl) {
      masters_.name_refused(object.axis, reply);
    }
  }
  reply.tick = clock_.next_tick();
  return reason_of(reply);
}

Reason AxisRequests::write_object(const msg::ObjectAccess& object, std::uint64_t session,
                                  std::size_t place) {
  const auto axis = axes_.index_of(object.axis);
  if (!axis) return msg::Reason::unknown_axis;
  const ObjectAddress address{object.index, object.subindex};
  const auto row = find_object(address);
  const std::uint64_t owner = masters_.owner(*axis).session;
  const bool is_of_other = owner != 0 && owner != session;
  const Stop stop = row ? stop_in(*row, object.value) : Stop::none;
  // Any session may quick-stop an axis, and does not become its owner. A halt of a free axis is an
  // ordinary command, which makes its session the owner.
  const bool stops = is_of_other ? stop != Stop::none : owner == 0 && stop == Stop::quick_stop;
  if (stops) return stop_axis(*axis, stop == Stop::halt, session);
  if (is_of_other && !(row && has_role(*row, Role::test_input))) return kLocalControl;
  if (!row) return check_address(address);
  if (owner == 0 && has_role(*row, Role::command)) {
    return write_command_object(*axis, *row, object.value, session);
  }
  if (describe(*row).change == Change::memory) {
    return stores_.store_by_write(*axis, *row, object.value, place);
  }
  return writer_.write(*axis, *row, object.value);
}

/// A halt sets bit 8 and leaves the other bits of the controlword unchanged, so that the set-point
/// and its handshake with the owner are kept.
Reason AxisRequests::stop_axis(std::size_t axis, bool by_halt, std::uint64_t session) {
  const auto present =
      static_cast<std::uint16_t>(axes_.bank().read(axis, "ds402_controlword"_object).value);
  const auto halted = static_cast<std::uint16_t>(present | Controlword::kHalt);
  const std::uint16_t word = by_halt ? halted : controlwords::kQuickStop;
  if (word == present) return AbortCode::none;
  const AbortCode code = writer_.write(axis, "ds402_controlword"_object, word);
  if (code != AbortCode::none) return code;
  schedule_.cancel_of_axis(axes_.number_of(axis));
  const std::uint64_t owner = masters_.owner(axis).session;
  if (owner != 0) {
    events_.report({.kind = msg::EventKind::stopped,
                    .axis = axes_.number_of(axis),
                    .session = session,
                    .code = word,
                    .detail = Label{owner}});
  }
  return AbortCode::none;
}

/// Writes a command object of a free axis. If it is accepted, the session becomes the owner.
Reason AxisRequests::write_command_object(std::size_t axis, ObjectRow row, std::int64_t value,
                                          std::uint64_t session) {
  SessionRecord* const record = session == 0 ? nullptr : masters_.admit(session);
  if (record == nullptr) return kLocalControl;
  // The request may have been sent before the session lost its axes.
  if (record->must_acquire) return msg::Reason::stale_epoch;
  const AbortCode code = writer_.write(axis, row, value);
  if (code == AbortCode::none) masters_.give(axis, *record);
  return code;
}

}  // namespace vdrive::service

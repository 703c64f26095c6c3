// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/conversion.hpp"

#include "status_members.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace vdrive::wire {
namespace {

using namespace vdrive::literals;

/// A member of the AxisParameters message.
struct ParameterMember {
  ObjectRow row;
  void (*assign)(msg::AxisParameters& message, std::int64_t value);
};

template <typename Integer>
constexpr Integer as(std::int64_t value) noexcept {
  return static_cast<Integer>(value);
}

constexpr std::array<ParameterMember, 17> kParameterMembers{{
    {"ds402_controlword"_object,
     [](auto& m, auto value) {
       m.ds402_controlword(as<std::uint16_t>(value));
     }},
    {"op_mode_cmd"_object,
     [](auto& m, auto value) {
       m.op_mode_cmd(as<std::int8_t>(value));
     }},
    {"position_target_reached_window"_object,
     [](auto& m, auto value) {
       m.position_target_reached_window(as<std::uint32_t>(value));
     }},
    {"position_target_reached_window_time"_object,
     [](auto& m, auto value) {
       m.position_target_reached_window_time(as<std::uint16_t>(value));
     }},
    {"position_user_target_value"_object,
     [](auto& m, auto value) {
       m.position_user_target_value(as<std::int32_t>(value));
     }},
    {"user_position_lower_limit"_object,
     [](auto& m, auto value) {
       m.user_position_lower_limit(as<std::int32_t>(value));
     }},
    {"user_position_upper_limit"_object,
     [](auto& m, auto value) {
       m.user_position_upper_limit(as<std::int32_t>(value));
     }},
    {"app_speed_limit"_object,
     [](auto& m, auto value) {
       m.app_speed_limit(as<std::uint32_t>(value));
     }},
    {"motor_max_speed_rpm"_object,
     [](auto& m, auto value) {
       m.motor_max_speed_rpm(as<std::uint32_t>(value));
     }},
    {"profile_velocity"_object,
     [](auto& m, auto value) {
       m.profile_velocity(as<std::uint32_t>(value));
     }},
    {"profile_acc"_object,
     [](auto& m, auto value) {
       m.profile_acc(as<std::uint32_t>(value));
     }},
    {"profile_dec"_object,
     [](auto& m, auto value) {
       m.profile_dec(as<std::uint32_t>(value));
     }},
    {"app_acc_limit"_object,
     [](auto& m, auto value) {
       m.app_acc_limit(as<std::uint32_t>(value));
     }},
    {"app_dec_limit"_object,
     [](auto& m, auto value) {
       m.app_dec_limit(as<std::uint32_t>(value));
     }},
    {"positive_torque_limit_relative"_object,
     [](auto& m, auto value) {
       m.positive_torque_limit_relative(as<std::uint16_t>(value));
     }},
    {"negative_torque_limit_relative"_object,
     [](auto& m, auto value) {
       m.negative_torque_limit_relative(as<std::uint16_t>(value));
     }},
    {"positioning_option_code"_object,
     [](auto& m, auto value) {
       m.positioning_option_code(as<std::uint16_t>(value));
     }},
}};

constexpr std::array kReasons{
    ReasonRow{msg::REASON_NONE, "none", "accepted"},
    ReasonRow{msg::REASON_WRONG_INCARNATION, "wrong_incarnation",
              "meant for another run of the service"},
    ReasonRow{msg::REASON_STALE_EPOCH, "stale_epoch",
              "the epoch is not current: control was lost, released or renewed"},
    ReasonRow{msg::REASON_NOT_OWNER, "not_owner", "the session does not own the axis"},
    ReasonRow{msg::REASON_UNKNOWN_AXIS, "unknown_axis", "no such axis"},
    ReasonRow{msg::REASON_AXIS_TWICE, "axis_twice", "the axis appears twice in one frame"},
    ReasonRow{msg::REASON_TOO_MANY_AXES, "too_many_axes", "more axes than a frame may hold"},
    ReasonRow{msg::REASON_TOO_MANY_OBJECTS, "too_many_objects",
              "more objects than the message may hold"},
    ReasonRow{msg::REASON_UNKNOWN_MEMBERS, "unknown_members", "unknown bits in members"},
    ReasonRow{msg::REASON_UNKNOWN_FLAGS, "unknown_flags", "unknown bits in flags"},
    ReasonRow{msg::REASON_UNKNOWN_KIND, "unknown_kind", "unknown kind of request"},
    ReasonRow{msg::REASON_TOO_LATE, "too_late",
              "too late: its tick or its place in the sequence has passed"},
    ReasonRow{msg::REASON_TOO_FAR_AHEAD, "too_far_ahead", "the tick is too far ahead"},
    ReasonRow{msg::REASON_QUEUE_FULL, "queue_full", "the queue is full"},
    ReasonRow{msg::REASON_WRONG_CLOCK_MODE, "wrong_clock_mode", "not in this clock mode"},
    ReasonRow{msg::REASON_MISSING_COMMANDS, "missing_commands",
              "command frames sent before have not arrived"},
    ReasonRow{msg::REASON_BAD_SESSION, "bad_session", "session or client number is missing"},
    ReasonRow{msg::REASON_TOO_MANY_TICKS, "too_many_ticks",
              "more ticks than one request may ask for"},
    ReasonRow{msg::REASON_NOTHING_DONE, "nothing_done", "the request names nothing to do"},
    ReasonRow{msg::REASON_CANCELLED, "cancelled", "dropped while it waited for its tick"},
    ReasonRow{msg::REASON_MISSING_STEPPER, "missing_stepper",
              "another stepper has not granted the tick yet"},
    ReasonRow{msg::REASON_NOT_A_STEPPER, "not_a_stepper",
              "this session has not joined the clock; others have, or are awaited"},
    ReasonRow{msg::REASON_TIME_PASSES, "time_passes",
              "allowed only while time stands still: in lock-step, or paused"},
    ReasonRow{msg::REASON_UNKNOWN_SNAPSHOT, "unknown_snapshot", "no such snapshot"},
    ReasonRow{msg::REASON_OUT_OF_RANGE, "out_of_range",
              "the rate is neither 0 nor from 0.1 to 100"},
    ReasonRow{msg::REASON_SHUTTING_DOWN, "shutting_down", "the service shuts down"},
    ReasonRow{msg::REASON_TOO_MANY_SNAPSHOTS, "too_many_snapshots",
              "the bench already keeps 16 snapshots; drop one of them"},
    ReasonRow{msg::REASON_TOO_MANY_STEPPERS, "too_many_steppers",
              "a clock has at most 64 steppers"},
};
static_assert(msg::MAX_SNAPSHOTS == 16 && msg::MAX_STEPPERS == 64, "the texts say so");

}  // namespace

void to_message(const AxisStatus& status, const AxisAddress& address, std::uint64_t tick,
                const Ownership& owner, msg::AxisStatus& message) {
  message.bench(address.bench);
  message.axis(address.axis);
  message.tick(tick);
  message.owner_session(owner.session);
  message.owner_epoch(owner.epoch);
  message.last_sequence(owner.last_sequence);
  for_each_status_member([&](auto member, const auto& in_message) {
    in_message(message) = status.*member;
  });
}

AxisStatus from_message(const msg::AxisStatus& message) {
  AxisStatus status;
  for_each_status_member([&](auto member, const auto& in_message) {
    status.*member = in_message(message);
  });
  return status;
}

void to_message(const AxisBank& bank, std::size_t index, const AxisAddress& address,
                std::uint64_t tick, msg::AxisParameters& message) {
  message.bench(address.bench);
  message.axis(address.axis);
  message.tick(tick);
  for (const auto& member : kParameterMembers) {
    member.assign(message, bank.read(index, vdrive::describe(member.row).address).value);
  }
}

std::uint32_t clock_mode_code(ClockMode mode) noexcept {
  switch (mode) {
    case ClockMode::lockstep:
      return msg::CLOCK_MODE_LOCKSTEP;
    case ClockMode::freerun:
      return msg::CLOCK_MODE_FREERUN;
    default:
      return msg::CLOCK_MODE_REALTIME;
  }
}

ClockMode clock_mode_of(std::uint32_t code) noexcept {
  const auto* const mode = std::ranges::find_if(kClockModes, [code](auto each) {
    return clock_mode_code(each) == code;
  });
  return mode == kClockModes.end() ? ClockMode::realtime : *mode;
}

void to_message(const Unit& unit, msg::AxisDescription& message) {
  message.unit_kind(unit.kind == UnitKind::rotary ? msg::UNIT_ROTARY : msg::UNIT_LINEAR);
  message.unit_name(unit.name);
  message.unit_size(unit.size);
}

Unit unit_of(const msg::AxisDescription& message) {
  const bool is_known =
      message.unit_kind() == msg::UNIT_ROTARY || message.unit_kind() == msg::UNIT_LINEAR;
  const Unit unit{
      .kind = message.unit_kind() == msg::UNIT_LINEAR ? UnitKind::linear : UnitKind::rotary,
      .name = message.unit_name().to_string(),
      .size = message.unit_size()};
  return is_known && is_usable(unit) ? unit : Unit();
}

std::span<const ReasonRow> reasons() noexcept {
  return kReasons;
}

std::string describe_reason(std::uint32_t reason) {
  const auto* const row = std::ranges::find(kReasons, reason, &ReasonRow::reason);
  if (row != kReasons.end()) return std::string(row->words);
  return hex(reason, 8) + ", " + std::string(vdrive::describe(static_cast<AbortCode>(reason)));
}

}  // namespace vdrive::wire

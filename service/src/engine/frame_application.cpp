// SPDX-License-Identifier: Apache-2.0
#include "engine/frame_application.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;

/// A register member of AxisCommand. The rows are in the order of their bits, which is the order of
/// application.
struct RegisterMember {
  std::uint16_t bit = 0;
  ObjectRow row = 0;
  std::int64_t (*value)(const msg::AxisCommand& command) = nullptr;
};

constexpr std::array<RegisterMember, 6> kRegisterMembers{{
    {msg::HAS_OP_MODE_CMD, "op_mode_cmd"_object,
     [](const auto& c) -> std::int64_t {
       return c.op_mode_cmd;
     }},
    {msg::HAS_POSITION_USER_TARGET_VALUE, "position_user_target_value"_object,
     [](const auto& c) -> std::int64_t {
       return c.position_user_target_value;
     }},
    {msg::HAS_PROFILE_VELOCITY, "profile_velocity"_object,
     [](const auto& c) -> std::int64_t {
       return c.profile_velocity;
     }},
    {msg::HAS_PROFILE_ACC, "profile_acc"_object,
     [](const auto& c) -> std::int64_t {
       return c.profile_acc;
     }},
    {msg::HAS_PROFILE_DEC, "profile_dec"_object,
     [](const auto& c) -> std::int64_t {
       return c.profile_dec;
     }},
    {msg::HAS_POSITIONING_OPTION_CODE, "positioning_option_code"_object,
     [](const auto& c) -> std::int64_t {
       return c.positioning_option_code;
     }},
}};

/// Objects whose values decide whether writes to others are accepted: 607Bh decides on 60F2h,
/// 5E20h:05 on 6060h. An all-or-nothing frame may not contain them, because it is checked in full
/// before any of it is written.
constexpr bool affects_other_checks(ObjectRow row) {
  return row == "min_position_range_limit"_object || row == "max_position_range_limit"_object ||
         row == "habit_mode_change_refusal"_object;
}

JournalAuthor author_of(const msg::CommandFrame& frame) {
  return {.means = JournalAuthor::Means::frame, .session = frame.session};
}

constexpr std::uint16_t kKnownMembers = [] {
  std::uint16_t members = msg::HAS_DS402_CONTROLWORD;
  for (const auto& member : kRegisterMembers) {
    members = static_cast<std::uint16_t>(members | member.bit);
  }
  return members;
}();

}  // namespace

FrameApplication::FrameApplication(BenchAxes& axes, AxisWriter& writer, Masters& masters,
                                   FrameAnswers& answers, BenchEvents& events, Counters& counters)
    : axes_(axes),
      writer_(writer),
      masters_(masters),
      answers_(answers),
      events_(events),
      counters_(counters),
      targets_(msg::MAX_AXES_PER_FRAME),
      named_in_(axes.size()) {
  reply_.refusals.reserve(msg::MAX_AXES_PER_FRAME);
  reply_.ignored_set_points.reserve(msg::MAX_AXES_PER_FRAME);
}

void FrameApplication::apply(const msg::CommandFrame& frame) {
  ensure(frame.axes.size() <= targets_.size(), "the decoder refuses frames of more axes");
  const BenchAxes::Authorship author(axes_, author_of(frame));
  begin(frame);
  if ((frame.flags & msg::FRAME_ALL_OR_NOTHING) == 0) {
    apply_each(frame);
  } else if (reply_.refusals.empty()) {
    apply_all_or_nothing(frame);
  }
  const bool is_refused = !reply_.refusals.empty();
  if (is_refused) {
    if ((frame.flags & msg::FRAME_ALL_OR_NOTHING) != 0) record_left_out(frame);
    counters_.frames_refused.add();
    const auto& first = reply_.refusals.front();
    events_.report({.kind = msg::EventKind::refused,
                    .axis = first.axis,
                    .session = frame.session,
                    .code = wire::number(first.reason),
                    .detail = RefusedMessage{.number = frame.sequence_number}});
  }
  const bool has_news = is_refused || !reply_.ignored_set_points.empty();
  if (has_news || (frame.flags & msg::FRAME_WANT_REPLY) != 0) answers_.send(frame, reply_);
}

void FrameApplication::begin(const msg::CommandFrame& frame) {
  reply_.refusals.clear();
  reply_.ignored_set_points.clear();
  ++frame_count_;
  const auto& commands = frame.axes;
  for (std::size_t position = 0; position < commands.size(); ++position) {
    Target& target = targets_[position];
    const Reason reason = admit(commands[position], frame.session, target);
    target.is_refused = reason != msg::Reason::none;
    if (!target.is_refused) continue;
    refuse(commands[position].axis, {}, reason);
    if (reason != msg::Reason::unknown_axis) {
      record_refused(commands[position], target.axis, reason);
    }
  }
}

/// In a refused all-or-nothing frame, records the commands that are only refused because another
/// one was.
void FrameApplication::record_left_out(const msg::CommandFrame& frame) {
  for (std::size_t position = 0; position < frame.axes.size(); ++position) {
    const Target& target = targets_[position];
    if (!target.is_refused) {
      record_refused(frame.axes[position], target.axis, reply_.refusals.front().reason);
    }
  }
}

void FrameApplication::record_refused(const msg::CommandFrame& frame, Reason reason) {
  const BenchAxes::Authorship author(axes_, author_of(frame));
  for (const auto& command : frame.axes) {
    if (const auto axis = axes_.index_of(command.axis)) record_refused(command, *axis, reason);
  }
}

void FrameApplication::record_refused(const msg::AxisCommand& command, std::size_t axis,
                                      Reason reason) {
  for (const auto& member : kRegisterMembers) {
    if ((command.members & member.bit) != 0) {
      axes_.record_refusal(axis, describe(member.row).address, member.value(command), reason);
    }
  }
  for (const auto& object : command.objects) {
    axes_.record_refusal(axis, {object.index, object.subindex}, object.value, reason);
  }
  if ((command.members & msg::HAS_DS402_CONTROLWORD) != 0) {
    axes_.record_refusal(axis, describe("ds402_controlword"_object).address,
                         command.ds402_controlword, reason);
  }
}

/// @return whether the frame names the axis for the first time.
bool FrameApplication::mark_named(std::size_t axis) {
  const bool is_first = named_in_[axis] != frame_count_;
  named_in_[axis] = frame_count_;
  return is_first;
}

/// @return REASON_NONE, or why the command is refused.
Reason FrameApplication::admit(const msg::AxisCommand& command, std::uint64_t session,
                               Target& target) {
  const auto axis = axes_.index_of(command.axis);
  if (!axis) return msg::Reason::unknown_axis;
  target.axis = *axis;
  if (!mark_named(*axis)) return msg::Reason::axis_twice;
  if (masters_.owner(*axis).session != session) return msg::Reason::not_owner;
  if ((command.members & ~kKnownMembers) != 0) return msg::Reason::unknown_members;
  return msg::Reason::none;
}

void FrameApplication::apply_each(const msg::CommandFrame& frame) {
  const auto& commands = frame.axes;
  for (std::size_t position = 0; position < commands.size(); ++position) {
    const Target& target = targets_[position];
    if (target.is_refused) {
      counters_.commands_refused.add();
      continue;
    }
    const bool whole = pass_registers(commands[position], target.axis, Pass::write);
    apply_controlword(commands[position], target.axis, frame.sequence_number);
    (whole ? counters_.commands_applied : counters_.commands_refused).add();
  }
}

/// Writes nothing before everything is accepted: a write can have more effects than the change of
/// its register, and restoring the old value would not undo them.
void FrameApplication::apply_all_or_nothing(const msg::CommandFrame& frame) {
  bool accepted = true;
  const auto& commands = frame.axes;
  for (std::size_t position = 0; position < commands.size(); ++position) {
    accepted = pass_registers(commands[position], targets_[position].axis, Pass::judge) && accepted;
  }
  if (!accepted) {
    counters_.commands_refused.add(commands.size());
    return;
  }
  for (std::size_t position = 0; position < commands.size(); ++position) {
    const std::size_t axis = targets_[position].axis;
    const bool written = pass_registers(commands[position], axis, Pass::write);
    ensure(written, "a register that was accepted is written");
  }
  for (std::size_t position = 0; position < commands.size(); ++position) {
    apply_controlword(commands[position], targets_[position].axis, frame.sequence_number);
  }
  counters_.commands_applied.add(commands.size());
}

/// @return whether all registers are accepted.
bool FrameApplication::pass_registers(const msg::AxisCommand& command, std::size_t axis,
                                      Pass pass) {
  bool accepted = true;
  for (const auto& member : kRegisterMembers) {
    if ((command.members & member.bit) != 0) {
      accepted = pass_register(axis, member.row, member.value(command), pass) && accepted;
    }
  }
  for (const auto& object : command.objects) {
    const ObjectAddress address{object.index, object.subindex};
    if (const auto row = find_object(address)) {
      accepted = pass_register(axis, *row, object.value, pass) && accepted;
    } else {
      refuse(command.axis, address, check_address(address));
      if (pass == Pass::write) {
        axes_.record_refusal(axis, address, object.value, check_address(address));
      }
      accepted = false;
    }
  }
  return accepted;
}

bool FrameApplication::pass_register(std::size_t axis, ObjectRow row, std::int64_t value,
                                     Pass pass) {
  // Refuses the controlword, which has its own member and is applied last, and the objects that
  // store parameters: a store is answered once it is durable, a frame immediately.
  const Change change = describe(row).change;
  const bool judges = pass == Pass::judge;
  AbortCode code = AbortCode::cannot_be_mapped_to_pdo;
  if (change != Change::power && change != Change::memory &&
      !(judges && affects_other_checks(row))) {
    // Without the AxisWriter, because these registers cannot begin a halt.
    code = judges ? axes_.bank().check(axis, row, value) : axes_.write(axis, row, value);
  }
  if (code == AbortCode::none) return true;
  refuse(axes_.number_of(axis), describe(row).address, code);
  if (!judges) axes_.record_refusal(axis, describe(row).address, value, code);
  return false;
}

void FrameApplication::apply_controlword(const msg::AxisCommand& command, std::size_t axis,
                                         std::uint64_t sequence) {
  if ((command.members & msg::HAS_DS402_CONTROLWORD) != 0) {
    const std::uint32_t ignored = axes_.bank().ignored_set_points(axis);
    const AbortCode code =
        writer_.write(axis, "ds402_controlword"_object, command.ds402_controlword);
    if (code != AbortCode::none) {
      const ObjectAddress controlword = describe("ds402_controlword"_object).address;
      refuse(command.axis, controlword, code);
      axes_.record_refusal(axis, controlword, command.ds402_controlword, code);
    } else if (axes_.bank().ignored_set_points(axis) != ignored) {
      reply_.ignored_set_points.push_back(command.axis);
    }
  }
  masters_.set_applied(axis, sequence);
}

void FrameApplication::refuse(std::uint16_t axis, ObjectAddress address, Reason reason) {
  counters_.refusals.add(reason.code());
  auto& refusals = reply_.refusals;
  if (refusals.size() == msg::MAX_AXES_PER_FRAME) return;
  auto& refusal = refusals.emplace_back();
  refusal.axis = axis;
  refusal.index = address.index;
  refusal.subindex = address.subindex;
  refusal.reason = reason.on_wire();
}

}  // namespace vdrive::service

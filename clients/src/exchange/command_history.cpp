// SPDX-License-Identifier: Apache-2.0
#include "exchange/command_history.hpp"

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/standing_targets.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace vdrive::client {
namespace {

using namespace literals;

// More commands than a program gives one axis before it waits for the first of them.
constexpr std::size_t kMostOfAxis = 64;

constexpr std::uint16_t kAllAxes = 0;
constexpr std::size_t kDigitsOfWord = 4;

struct CommandName {
  PowerCommand command;
  std::string_view name;
};

/// The commands that leave Operation enabled.
constexpr std::array kLeaving{CommandName{PowerCommand::disable_voltage, "disable voltage"},
                              CommandName{PowerCommand::quick_stop, "quick stop"},
                              CommandName{PowerCommand::shutdown, "shutdown"},
                              CommandName{PowerCommand::switch_on, "disable operation"}};

/// @return the name of the command if it leaves Operation enabled, otherwise empty.
std::string_view leaving(std::uint16_t word) {
  const auto* const row =
      std::ranges::find(kLeaving, decode_command(word, 0), &CommandName::command);
  return row == kLeaving.end() ? std::string_view() : row->name;
}

bool ends_something(std::uint16_t word) {
  return (word & Controlword::kNewSetPoint) != 0 || !leaving(word).empty();
}

/// @return whether bit 4 of 6040h starts an action in the mode.
bool has_start_bit(OperatingMode mode) {
  return mode == OperatingMode::profile_position || mode == OperatingMode::homing;
}

/// @return the object that the mode follows as soon as it is written, and whose value a call waits
///         for.
std::optional<ObjectAddress> written_target(OperatingMode mode) {
  switch (mode) {
    case OperatingMode::velocity:
      return kTargetOfVelocityMode;
    case OperatingMode::profile_velocity:
      return kTargetVelocity;
    case OperatingMode::profile_torque:
      return kTargetTorque;
    default:
      return std::nullopt;
  }
}

bool contains(std::span<const ObjectAddress> written, std::optional<ObjectAddress> target) {
  return target && std::ranges::find(written, *target) != written.end();
}

bool is_standing_target(ObjectAddress address) {
  return std::ranges::find(kStandingTargets, address) != kStandingTargets.end();
}

}  // namespace

bool ends_motion(const msg::AxisCommand& command) noexcept {
  const bool has_word = (command.members & msg::HAS_DS402_CONTROLWORD) != 0;
  const bool has_target = std::ranges::any_of(command.objects, [](const msg::ObjectValue& each) {
    return is_standing_target({each.index, each.subindex});
  });
  return has_target || (command.members & msg::HAS_OP_MODE_CMD) != 0 ||
         (has_word && ends_something(command.ds402_controlword));
}

CommandHistory::Entry CommandHistory::entry_of(const msg::AxisCommand& command) {
  Entry entry;
  const std::uint16_t word = command.ds402_controlword;
  if ((command.members & msg::HAS_OP_MODE_CMD) != 0) {
    entry.mode = static_cast<OperatingMode>(command.op_mode_cmd);
  }
  if ((command.members & msg::HAS_DS402_CONTROLWORD) != 0 && ends_something(word)) {
    entry.controlword = word;
  }
  if ((command.members & msg::HAS_POSITION_USER_TARGET_VALUE) != 0) {
    entry.target = command.position_user_target_value;
  }
  for (const msg::ObjectValue& object : command.objects) {
    const ObjectAddress address{object.index, object.subindex};
    if (is_standing_target(address)) entry.written.push_back(address);
  }
  return entry;
}

CommandHistory::Entry CommandHistory::entry_of(const msg::ObjectAccess& access) {
  Entry entry;
  const auto row = find_object({access.index, access.subindex});
  if (!row) return entry;
  const ObjectAddress address = describe(*row).address;
  const auto word = static_cast<std::uint16_t>(access.value);
  if (*row == "op_mode_cmd"_object) entry.mode = static_cast<OperatingMode>(access.value);
  if (*row == "ds402_controlword"_object && ends_something(word)) entry.controlword = word;
  if (is_standing_target(address)) entry.written.push_back(address);
  return entry;
}

/// Called with the mutex held. Another run of the service starts with an empty history.
void CommandHistory::add(const BenchKey& key, std::uint16_t axis, Entry entry) {
  OfBench& bench = benches_[key.number];
  if (bench.incarnation != key.incarnation) bench = {.incarnation = key.incarnation, .axes = {}};
  Entries& entries = bench.axes[axis];
  if (entries.size() == kMostOfAxis) {
    // Drop the oldest target of a stream: only the newest matter.
    const auto oldest = std::ranges::find_if(entries, [](const Entry& each) {
      return !each.written.empty() && !each.mode && !each.controlword;
    });
    entries.erase(oldest == entries.end() ? entries.begin() : oldest);
  }
  entries.push_back(std::move(entry));
}

void CommandHistory::note_frame(const BenchKey& key, const msg::CommandFrame& frame) {
  for (const msg::AxisCommand& command : frame.axes) {
    if (!ends_motion(command)) continue;  // like nearly all commands of a stream
    Entry entry = entry_of(command);
    entry.after = frame.sequence_number - 1;
    entry.all_or_nothing = (frame.flags & msg::FRAME_ALL_OR_NOTHING) != 0;
    const std::scoped_lock lock(mutex_);
    add(key, command.axis, std::move(entry));
  }
}

/// Removes the parts of a frame that the drive refused or ignored.
void CommandHistory::remove_refused(Entry& entry, std::uint16_t axis,
                                    const msg::CommandReply& reply) {
  constexpr ObjectAddress kMode = kObjectRows["op_mode_cmd"_object].address;
  constexpr ObjectAddress kControlword = kObjectRows["ds402_controlword"_object].address;
  const auto& ignored = reply.ignored_set_points;
  if (std::ranges::find(ignored, axis) != ignored.end()) entry.controlword.reset();
  for (const msg::Refusal& refusal : reply.refusals) {
    if (refusal.axis != axis) continue;
    const ObjectAddress refused{refusal.index, refusal.subindex};
    if (refused == kMode) entry.mode.reset();
    if (refused == kControlword) entry.controlword.reset();
    std::erase(entry.written, refused);
  }
}

/// The accepted part of a frame still counts, such as a mode whose set-point was ignored.
void CommandHistory::forget_refused(Entries& entries, std::uint16_t axis,
                                    const msg::CommandReply& reply) {
  const auto entry = std::ranges::find_if(entries, [&reply](const Entry& each) {
    return each.tick == 0 && each.after + 1 == reply.sequence_number;
  });
  if (entry == entries.end()) return;
  const bool is_refused = std::ranges::any_of(reply.refusals, [&](const msg::Refusal& refusal) {
    const bool is_of_axis = refusal.axis == axis && refusal.index == 0;
    return refusal.axis == 0 || entry->all_or_nothing || is_of_axis;
  });
  remove_refused(*entry, axis, reply);
  const bool is_empty = !entry->mode && !entry->controlword && entry->written.empty();
  if (is_refused || is_empty) entries.erase(entry);
}

void CommandHistory::note_answer(const msg::CommandReply& reply) {
  if (reply.refusals.empty() && reply.ignored_set_points.empty()) return;
  const std::scoped_lock lock(mutex_);
  const auto bench = benches_.find(reply.bench);
  if (bench == benches_.end() || bench->second.incarnation != reply.incarnation) return;
  for (auto& [axis, entries] : bench->second.axes) forget_refused(entries, axis, reply);
}

/// Called with the mutex held.
void CommandHistory::note_writes(const BenchKey& key, const msg::Request& request,
                                 const msg::Reply& reply, std::uint64_t last_sequence) {
  const std::size_t count = std::min(request.objects.size(), reply.objects.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (reply.objects[i].abort_code != msg::Reason::none) continue;
    Entry entry = entry_of(request.objects[i]);
    if (!entry.mode && !entry.controlword && entry.written.empty()) continue;
    entry.after = last_sequence;
    entry.tick = reply.tick;
    add(key, request.objects[i].axis, std::move(entry));
  }
}

void CommandHistory::note_request(const BenchKey& key, const msg::Request& request,
                                  const msg::Reply& reply, std::uint64_t last_sequence) {
  const std::scoped_lock lock(mutex_);
  switch (request.kind) {
    case msg::RequestKind::write:
      note_writes(key, request, reply, last_sequence);
      break;
    case msg::RequestKind::power_cycle:
      for (const std::uint16_t axis : request.axes) {
        add(key, axis, {.after = last_sequence, .tick = reply.tick, .what = "a power cycle"});
      }
      break;
    case msg::RequestKind::restore_snapshot:
      add(key, kAllAxes,
          {.after = last_sequence, .tick = reply.tick, .what = "a restored snapshot"});
      break;
    default:
      break;
  }
}

void CommandHistory::note_gained(const BenchKey& key, std::span<const std::uint16_t> axes,
                                 std::uint64_t last_sequence) {
  const std::scoped_lock lock(mutex_);
  for (const std::uint16_t axis : axes) {
    // Tick 1 marks a request that is in force already. It supersedes every earlier command of this
    // session to the axis.
    add(key, axis, {.after = last_sequence, .tick = 1, .what = "a new acquisition of the axis"});
  }
}

bool CommandHistory::is_in_force(const Entry& entry, const AxisSnapshot& seen) {
  return entry.tick != 0 ? seen.tick >= entry.tick : seen.last_sequence > entry.after;
}

bool CommandHistory::ends(const Entry& entry, OperatingMode mode) {
  if (!entry.what.empty()) return true;
  constexpr OperatingMode kSetPoints = OperatingMode::profile_position;
  const bool stays = entry.mode == kSetPoints && mode == kSetPoints;
  if (entry.mode && !stays) return true;
  if (contains(entry.written, written_target(mode))) return true;
  return entry.controlword && (has_start_bit(mode) || !leaving(*entry.controlword).empty());
}

std::string CommandHistory::text_of(const Entry& entry, OperatingMode mode) {
  const auto word = [&entry] {
    return "6040h = " + hex(*entry.controlword, kDigitsOfWord);
  };
  if (!entry.what.empty()) return std::string(entry.what);
  if (entry.controlword && !leaving(*entry.controlword).empty()) {
    return std::string(leaving(*entry.controlword)) + " (" + word() + ")";
  }
  if (entry.mode && entry.mode != OperatingMode::profile_position) {
    return std::string(to_string(*entry.mode)) +
           " mode (6060h = " + std::to_string(static_cast<int>(*entry.mode)) + ")";
  }
  if (const auto target = written_target(mode); contains(entry.written, target)) {
    return "a write of " + object_text(*target);
  }
  if (!entry.controlword) return "profile position mode (6060h = 1)";
  return "a later set-point (" + word() +
         (entry.target ? ", 607Ah = " + std::to_string(*entry.target) : "") + ")";
}

std::optional<std::string> CommandHistory::find_end(const BenchKey& key, const GivenCommand& given,
                                                    const AxisSnapshot& seen) const {
  const std::scoped_lock lock(mutex_);
  const auto bench = benches_.find(key.number);
  if (bench == benches_.end() || bench->second.incarnation != key.incarnation) return std::nullopt;
  for (const std::uint16_t axis : {seen.id.axis, kAllAxes}) {
    const auto entries = bench->second.axes.find(axis);
    if (entries == bench->second.axes.end()) continue;
    for (const Entry& entry : entries->second) {
      if (entry.after >= given.sequence && is_in_force(entry, seen) && ends(entry, given.mode)) {
        return text_of(entry, given.mode);
      }
    }
  }
  return std::nullopt;
}

}  // namespace vdrive::client

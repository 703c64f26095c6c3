// SPDX-License-Identifier: Apache-2.0
#include "judge/power_rules.hpp"

#include "judge/words.hpp"
#include "vdrive/cia402/controlword.hpp"

#include <string>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;

constexpr Time kReactionToFault = 100ms;  ///< for messages sent before the master saw the fault
constexpr Time kKeptBit = 500ms;  ///< a PDO repeats its controlword: shorter repeats do not count
constexpr Time kAnswerByChange = 500ms;  ///< without a status by then, nothing has changed
constexpr Time kStormTime = 10s;
constexpr std::size_t kStormResets = 5;
constexpr Time kPowerOnTime = 1s;

/// @return whether `state` accepts `command`: there is a transition, or the command is harmless.
bool has_command(PowerState state, PowerCommand command) {
  switch (command) {
    case PowerCommand::none:
    case PowerCommand::fault_reset:
    case PowerCommand::disable_voltage:
    case PowerCommand::quick_stop:
      return true;
    case PowerCommand::shutdown:
      return state != PowerState::quick_stop_active;
    case PowerCommand::switch_on:
    case PowerCommand::enable_operation:
      return state == PowerState::ready_to_switch_on || state == PowerState::switched_on ||
             state == PowerState::operation_enabled;
  }
  return true;
}

std::string word_of(PowerCommand command) {
  switch (command) {
    case PowerCommand::shutdown:
      return "Shutdown (0006h)";
    case PowerCommand::switch_on:
      return "Switch on (0007h)";
    case PowerCommand::enable_operation:
      return "Enable operation (000Fh)";
    default:
      return "the command";
  }
}

bool is_stop(const AxisTrack& track) {
  return track.commands(Controlword::kHalt) || track.state == PowerState::quick_stop_active;
}

}  // namespace

void PowerRules::forget() {
  *this = {};
}

void PowerRules::take(const Write& write, const Context& context) {
  if (write.object != objects::kControlword || !is_taken(write)) return;
  const AxisTrack& track = context.track;
  if (!track.has_status) return;
  const auto word = static_cast<std::uint16_t>(write.value);
  const PowerCommand decoded = decode_command(word, track.controlword);
  if (decoded == PowerCommand::fault_reset) {
    kept_since_.reset();
    if (track.state == PowerState::fault) reset(context);
    return;
  }
  if ((word & Controlword::kFaultReset) != 0) return keep_reset_bit(write, context);
  kept_since_.reset();
  const bool is_same = track.has_controlword && decoded == track.command;
  if (decoded != PowerCommand::none && !is_same) command(decoded, context);
}

void PowerRules::command(PowerCommand command, const Context& context) {
  remove_power(command, context);
  give_up(command, context);
  const AxisTrack& track = context.track;
  if (!has_command(track.state, command)) {
    if (track.expected != track.state && has_command(track.expected, command)) {
      if (track.state != PowerState::fault) {
        context.report(Rule::state_not_awaited, [&] {
          return word_of(command) + " came while 6041h still showed " +
                 std::string(to_string(track.state)) + " and not yet " +
                 std::string(to_string(track.expected));
        });
      }
    } else {
      command_without_transition(command, context);
    }
  }
  const bool needs_time =
      (command == PowerCommand::switch_on || command == PowerCommand::enable_operation) &&
      state_after(track.state, command) != track.state;
  if (needs_time) power_on_ = context.now();
}

void PowerRules::command_without_transition(PowerCommand command, const Context& context) const {
  const AxisTrack& track = context.track;
  const auto text = [&] {
    return word_of(command) + " in " + std::string(to_string(track.state));
  };
  if (track.state == PowerState::quick_stop_active) {
    const bool is_16 = command == PowerCommand::enable_operation;
    return context.report(is_16 ? Rule::state_transition_16 : Rule::state_quick_stop_left, text);
  }
  if (track.state == PowerState::switch_on_disabled && command == PowerCommand::enable_operation) {
    return context.report(Rule::state_skips_states, text);
  }
  if (track.state == PowerState::fault && has_reset_) {
    return context.report(Rule::state_reset_not_awaited, [&] {
      return word_of(command) + " came while 6041h still showed Fault after the reset";
    });
  }
  const bool is_late_word =
      is_fault(track.state) && context.now() - track.state_since < kReactionToFault;
  if (!is_late_word) context.report(Rule::state_no_such_command, text);
}

void PowerRules::reset(const Context& context) {
  const bool is_answered =
      reset_ && context.track.is_status_pushed && context.now() - *reset_ > kAnswerByChange;
  if (reset_ && !is_answered) {
    context.report(Rule::state_reset_not_awaited, [&] {
      return "a second reset came " + duration_text(context.now() - *reset_) +
             " after the first one, before any statusword was shown";
    });
  }
  reset_ = context.now();
  has_reset_ = true;
  if (!is_cause_known_ && context.track.error_code == 0) {
    context.report(Rule::state_cause_not_read, [] {
      return std::string(
          "fault reset (bit 7) before the master had read 603Fh or received an emergency");
    });
  }
  while (!resets_.empty() && context.now() - resets_.front() > kStormTime) resets_.pop_front();
  resets_.push_back(context.now());
  if (resets_.size() < kStormResets) return;
  context.report(Rule::state_reset_storm, [&] {
    return std::to_string(resets_.size()) + " resets within " +
           duration_text(context.now() - resets_.front());
  });
  resets_.clear();
}

/// A controlword with bit 7 still set.
void PowerRules::keep_reset_bit(const Write& write, const Context& context) {
  const AxisTrack& track = context.track;
  if (track.state != PowerState::fault || has_reset_) return kept_since_.reset();
  const bool is_meant = write.channel != Channel::pdo && context.now() > track.state_since;
  if (!kept_since_) kept_since_ = context.now();
  if (!is_meant && context.now() - *kept_since_ < kKeptBit) return;
  kept_since_ = context.now();
  context.report(Rule::state_reset_without_edge, [&] {
    return "6040h = " + hex_text(static_cast<std::uint16_t>(write.value)) +
           " in Fault, and bit 7 was up before";
  });
}

void PowerRules::remove_power(PowerCommand command, const Context& context) {
  const AxisTrack& track = context.track;
  const bool is_powered =
      track.state == PowerState::operation_enabled || track.state == PowerState::quick_stop_active;
  // 605Bh selects whether Shutdown brakes first: only a known 0 means that it does not.
  const bool coasts =
      command == PowerCommand::disable_voltage ||
      (command == PowerCommand::shutdown && track.values.find(objects::kShutdownOption) == 0);
  if (!is_powered || !coasts || !track.is_moving(context.now())) return;
  const bool is_cut = is_stop(track);
  context.report(is_cut ? Rule::supervision_stop_cut_short : Rule::state_power_off_in_motion, [&] {
    return "power was removed at position " + std::to_string(track.position.value_or(0)) +
           " while the axis " + (is_cut ? "was still braking" : "was moving");
  });
}

void PowerRules::give_up(PowerCommand command, const Context& context) {
  const bool is_down =
      command == PowerCommand::shutdown || command == PowerCommand::disable_voltage;
  if (power_on_ && is_down && context.track.expected != context.track.state &&
      !is_fault(context.track.state)) {
    const Time waited = context.now() - *power_on_;
    if (waited < kPowerOnTime) {
      context.report(Rule::state_gave_up, [&] {
        return "enabling was abandoned after " + duration_text(waited) + "; 6041h was " +
               std::string(to_string(context.track.state)) + " throughout";
      });
    }
  }
  power_on_.reset();
}

void PowerRules::take(const Shown& shown, const Context& context) {
  const AxisTrack& track = context.track;
  if (shown.has(ShownMember::kErrorCode) && shown.error_code != 0) is_cause_known_ = true;
  if (!shown.has(ShownMember::kStatusword)) return;
  reset_.reset();
  if (track.state == track.state_before) return;
  power_on_.reset();
  if (is_fault(track.state)) {
    if (!is_fault(track.state_before)) has_reset_ = false;
  } else {
    has_reset_ = false;
    is_cause_known_ = false;
  }
}

}  // namespace vdrive::judge

// SPDX-License-Identifier: Apache-2.0
#include "vdrive/cia402/power_state_machine.hpp"

#include <array>
#include <cassert>
#include <cstddef>

namespace vdrive {
namespace {

using enum PowerState;

constexpr std::size_t kStateCount = 8;
constexpr std::size_t kCommandCount = 7;

/// Target of each transition, by number. 13 can start in any state without a fault.
constexpr std::array<PowerState, 17> kTargets{
    not_ready_to_switch_on,  // 0
    switch_on_disabled,      // 1
    ready_to_switch_on,      // 2
    switched_on,             // 3
    operation_enabled,       // 4
    switched_on,             // 5
    ready_to_switch_on,      // 6
    switch_on_disabled,      // 7
    ready_to_switch_on,      // 8
    switch_on_disabled,      // 9
    switch_on_disabled,      // 10
    quick_stop_active,       // 11
    switch_on_disabled,      // 12
    fault_reaction_active,   // 13
    fault,                   // 14
    switch_on_disabled,      // 15
    operation_enabled,       // 16
};

/// Up to three successive transitions; 0 ends the list (transition 0 is never commanded).
using Path = std::array<unsigned char, 3>;
using Row = std::array<Path, kCommandCount>;
constexpr Path kStay{};

/// Reaction matrix. Columns: none, Disable voltage, Quick stop, Shutdown, Switch on / Disable
/// operation, Enable operation, Fault reset.
constexpr std::array<Row, kStateCount> kReactions{{
    /* Not ready to switch on */ {kStay, kStay, kStay, kStay, kStay, kStay, kStay},
    /* Switch on disabled     */ {kStay, kStay, kStay, Path{2}, kStay, Path{2, 3, 4}, kStay},
    /* Ready to switch on     */ {kStay, Path{7}, Path{7}, kStay, Path{3}, Path{3, 4}, kStay},
    /* Switched on            */ {kStay, Path{10}, Path{10}, Path{6}, kStay, Path{4}, kStay},
    /* Operation enabled      */ {kStay, Path{9}, Path{11}, Path{8}, Path{5}, kStay, kStay},
    /* Quick stop active      */ {kStay, Path{12}, kStay, kStay, kStay, Path{16}, kStay},
    /* Fault reaction active  */ {kStay, kStay, kStay, kStay, kStay, kStay, kStay},
    /* Fault                  */ {kStay, kStay, kStay, kStay, kStay, kStay, Path{15}},
}};

constexpr bool stays_in_quick_stop(const PowerOptions& options) {
  return options.quick_stop_option_code >= 5;
}

constexpr bool has_transition_16(const PowerOptions& options) {
  return options.transition_16 == Transition16::always ||
         (options.transition_16 == Transition16::by_option_code && stays_in_quick_stop(options));
}

/// Conditions that depend on settings and option codes rather than on the reaction matrix.
bool permitted(PowerState state, PowerCommand command, const PowerOptions& options, bool voltage,
               bool cause_present) {
  switch (state) {
    case switch_on_disabled:
      return voltage &&
             (command != PowerCommand::enable_operation || options.enable_from_switch_on_disabled);
    case quick_stop_active:
      return command != PowerCommand::enable_operation || has_transition_16(options);
    case fault:
      return !cause_present;
    default:
      return true;
  }
}

}  // namespace

void PowerStateMachine::take(unsigned number, TransitionSet& taken) noexcept {
  state_ = kTargets[number];
  pending_ = PowerCommand::none;
  taken.add(number);
}

TransitionSet PowerStateMachine::initialised() noexcept {
  TransitionSet taken;
  if (state_ == not_ready_to_switch_on) take(1, taken);
  return taken;
}

TransitionSet PowerStateMachine::command(PowerCommand command, const PowerOptions& options,
                                         bool voltage, bool cause_present) noexcept {
  TransitionSet taken;
  if (!permitted(state_, command, options, voltage, cause_present)) return taken;
  const bool ramped =
      state_ == operation_enabled &&
      ((command == PowerCommand::shutdown && options.shutdown_option_code == 1) ||
       (command == PowerCommand::switch_on && options.disable_operation_option_code == 1));
  if (ramped) {
    if (pending_ != PowerCommand::shutdown) pending_ = command;
    return taken;
  }
  if (command == PowerCommand::switch_on && pending_ == PowerCommand::shutdown) {
    return taken;  // the stronger stop continues
  }
  const Path& path =
      kReactions[static_cast<std::size_t>(state_)][static_cast<std::size_t>(command)];
  for (const unsigned number : path) {
    if (number != 0) take(number, taken);
  }
  return taken;
}

TransitionSet PowerStateMachine::fault_detected() noexcept {
  TransitionSet taken;
  if (state_ != fault_reaction_active && state_ != fault) take(13, taken);
  return taken;
}

TransitionSet PowerStateMachine::voltage_lost() noexcept {
  TransitionSet taken;
  if (state_ == ready_to_switch_on) {
    take(7, taken);
  } else if (state_ == switched_on) {
    take(10, taken);
  }
  return taken;
}

TransitionSet PowerStateMachine::power_dropped() noexcept {
  TransitionSet taken;
  if (state_ == operation_enabled) take(5, taken);
  return taken;
}

TransitionSet PowerStateMachine::stop_finished(const PowerOptions& options) noexcept {
  TransitionSet taken;
  if (state_ == fault_reaction_active) {
    take(14, taken);
  } else if (state_ == quick_stop_active && !stays_in_quick_stop(options)) {
    take(12, taken);
  } else if (state_ == operation_enabled && pending_ == PowerCommand::shutdown) {
    take(8, taken);
  } else if (state_ == operation_enabled && pending_ == PowerCommand::switch_on) {
    take(5, taken);
  }
  return taken;
}

}  // namespace vdrive

// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/command_words.hpp"

#include "base/drive_words.hpp"
#include "vdrive/cia402/enabling_words.hpp"
#include "vdrive/cia402/standing_targets.hpp"

namespace vdrive::client {
namespace {

std::vector<std::uint16_t> words_to_enable(PowerState state, const EnablingWay& way) {
  if (state == PowerState::not_ready_to_switch_on || state == PowerState::fault_reaction_active) {
    return {};
  }
  if (state == PowerState::quick_stop_active && way.keeps_power) return {kEnableOperation};
  std::vector<std::uint16_t> words;
  if (state == PowerState::fault) {
    if (!way.resets_fault) return {};
    words.push_back(Controlword::kFaultReset);
    state = PowerState::switch_on_disabled;
  }
  const auto rest = enabling_words(state);
  words.insert(words.end(), rest.begin(), rest.end());
  return words;
}

}  // namespace

std::vector<std::uint16_t> words_to(EachCommand command, PowerState state, const EnablingWay& way) {
  switch (command) {
    case EachCommand::enable:
      return words_to_enable(state, way);
    case EachCommand::disable:
      // An axis stays in this state after a quick stop if 605Ah is 5 or more.
      if (state == PowerState::quick_stop_active) return {kDisableVoltage, kShutdown};
      return {kShutdown};
    case EachCommand::halt:
      return {kHalt};
    case EachCommand::resume:
      return {kEnableOperation};
    case EachCommand::quick_stop:
      return {kQuickStop};
    case EachCommand::reset_fault:
      if (!is_fault(state)) return {};  // 0000h would remove the power from an axis that is enabled
      // Bit 7 rises and falls again, so that the next reset has an edge; 0000h has no effect in
      // Fault.
      return {kDisableVoltage, Controlword::kFaultReset, kDisableVoltage};
    case EachCommand::power_cycle:
      break;
  }
  return {};
}

std::vector<SetPoint> set_points_to(EachCommand command, const AxisSnapshot& axis,
                                    const EnablingWay& way) {
  std::vector<SetPoint> points;
  for (const std::uint16_t word : words_to(command, axis.state(), way)) {
    points.push_back({.axis = axis.id.axis, .controlword = word});
  }
  if (command == EachCommand::enable && !points.empty()) {
    for (const ObjectAddress target : kStandingTargets) {
      points.back().objects.push_back({.object = target});
    }
  }
  return points;
}

}  // namespace vdrive::client

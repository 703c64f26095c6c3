// SPDX-License-Identifier: Apache-2.0
// Prints src/data/tables.ts of the page: what it knows of messages and drives, from the schemas of
// the gateway and the tables of the core. The build of the page runs this program.
#include "descriptions.hpp"
#include "vdrive/cia402/bit_names.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/cia402/power_state_machine.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <iostream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::gateway {
namespace {

constexpr unsigned kHighestTransition = 16;
// In the order in which a statusword is compared with them; the last one applies to every word that
// matches no other state.
constexpr std::array kPowerStates{PowerState::switch_on_disabled,
                                  PowerState::ready_to_switch_on,
                                  PowerState::switched_on,
                                  PowerState::operation_enabled,
                                  PowerState::quick_stop_active,
                                  PowerState::fault_reaction_active,
                                  PowerState::fault,
                                  PowerState::not_ready_to_switch_on};
constexpr std::array kCommands{PowerCommand::disable_voltage,  PowerCommand::quick_stop,
                               PowerCommand::shutdown,         PowerCommand::switch_on,
                               PowerCommand::enable_operation, PowerCommand::fault_reset};

/// "Ready to switch on" becomes ready_to_switch_on.
std::string identifier_of(PowerState state) {
  std::string name(to_string(state));
  std::ranges::transform(name, name.begin(), [](unsigned char letter) {
    return letter == ' ' ? '_' : static_cast<char>(std::tolower(letter));
  });
  return name;
}

/// The mask and value of a state, derived from the words that decode to it: a bit belongs to the
/// mask if changing it changes the state.
Json statusword_row(PowerState state) {
  constexpr std::uint16_t kHighest = 0x7F;
  std::uint16_t mask = 0;
  std::uint16_t value = 0;
  for (std::uint16_t word = 0; word <= kHighest; ++word) {
    if (state == kPowerStates.back() || decode_power_state(word) != state) continue;
    value = word;
    for (std::uint16_t bit = 1; bit <= kHighest; bit = static_cast<std::uint16_t>(bit << 1U)) {
      if (decode_power_state(word ^ bit) != state) mask |= bit;
    }
  }
  return {{"state", identifier_of(state)},
          {"name", to_string(state)},
          {"mask", mask},
          {"value", value & mask}};
}

struct Transition {
  unsigned number = 0;
  PowerState from{};
  PowerState to{};

  auto operator<=>(const Transition&) const = default;
};

/// Every machine that results from `machine` by one event.
std::vector<std::pair<PowerStateMachine, TransitionSet>> after_one_event(
    const PowerStateMachine& machine, const PowerOptions& options) {
  std::vector<std::pair<PowerStateMachine, TransitionSet>> after;
  const auto add = [&](const auto& event) {
    PowerStateMachine next = machine;
    const TransitionSet taken = event(next);
    after.emplace_back(next, taken);
  };
  for (const PowerCommand command : kCommands) {
    add([&](PowerStateMachine& next) {
      return next.command(command, options, true, false);
    });
  }
  add([](PowerStateMachine& next) {
    return next.initialised();
  });
  add([](PowerStateMachine& next) {
    return next.fault_detected();
  });
  add([](PowerStateMachine& next) {
    return next.voltage_lost();
  });
  add([&](PowerStateMachine& next) {
    return next.stop_finished(options);
  });
  return after;
}

unsigned count_of(const TransitionSet& taken, unsigned& number) {
  unsigned count = 0;
  for (unsigned candidate = 1; candidate <= kHighestTransition; ++candidate) {
    if (!taken.contains(candidate)) continue;
    number = candidate;
    ++count;
  }
  return count;
}

/// The transitions that can occur alone: there is a state and an event that causes this transition
/// and no other one. Found by trying every event in every state that can be reached.
std::set<Transition> transitions() {
  // Option codes for which quick stop active can be left by enabling, and no transition waits for a
  // ramp.
  const PowerOptions options{.quick_stop_option_code = 6, .disable_operation_option_code = 0};
  std::set<Transition> found;
  std::map<PowerState, PowerStateMachine> open{{PowerState::not_ready_to_switch_on, {}}};
  std::set<PowerState> seen;
  while (!open.empty()) {
    const PowerStateMachine machine = open.extract(open.begin()).mapped();
    seen.insert(machine.state());
    for (const auto& [next, taken] : after_one_event(machine, options)) {
      unsigned number = 0;
      if (count_of(taken, number) == 1) found.insert({number, machine.state(), next.state()});
      if (!seen.contains(next.state())) open.emplace(next.state(), next);
    }
  }
  return found;
}

Json transition_rows() {
  Json rows = Json::array();
  for (const Transition& transition : transitions()) {
    rows.push_back({{"number", transition.number},
                    {"from", identifier_of(transition.from)},
                    {"to", identifier_of(transition.to)}});
  }
  return rows;
}

/// Every name of a bit of 6040h and 6041h, in any mode, with the Chinese name.
Json bit_name_rows() {
  constexpr unsigned kBits = 16;
  std::set<std::pair<std::string_view, std::string_view>> names;
  for (const OperatingModeRow& row : kOperatingModes) {
    for (unsigned place = 0; place < kBits; ++place) {
      const auto bit = static_cast<std::uint16_t>(1U << place);
      for (const BitName& found :
           {statusword_bit_names(bit, row.mode), controlword_bit_names(bit, row.mode)}) {
        if (!found.name.empty()) names.emplace(found.name, found.name_zh);
      }
    }
  }
  Json rows = Json::array();
  for (const auto& [name, name_zh] : names) rows.push_back({{"name", name}, {"name_zh", name_zh}});
  return rows;
}

Json mode_rows() {
  Json rows = Json::array();
  for (const OperatingModeRow& row : kOperatingModes) {
    rows.push_back(
        {{"mode", static_cast<int>(row.mode)}, {"name", row.name}, {"name_zh", row.name_zh}});
  }
  return rows;
}

Json statusword_rows() {
  Json rows = Json::array();
  for (const PowerState state : kPowerStates) rows.push_back(statusword_row(state));
  return rows;
}

void print(std::string_view name, const Json& value) {
  std::cout << "\nexport const " << name << " = " << value.dump(2) << " as const;\n";
}

void print_schema(std::string_view name, const ChannelInfo& channel) {
  print(name, Json::parse(channel.schema));
}

}  // namespace
}  // namespace vdrive::gateway

int main() {
  using namespace vdrive::gateway;
  std::cout << "// SPDX-License-Identifier: Apache-2.0\n"
               "// Printed by clients/gateway/page_tables.cpp.\n";
  print_schema("BENCH_DESCRIPTION", description_channel(""));
  print_schema("BENCH_STATE", state_channel(""));
  print_schema("CONTROL", control_channel());
  print_schema("DICTIONARY", dictionary_channel());
  print("POWER_STATES", statusword_rows());
  print("TRANSITIONS", transition_rows());
  print("OPERATING_MODES", mode_rows());
  print("BIT_NAMES", bit_name_rows());
}

// SPDX-License-Identifier: Apache-2.0
#include "bridge/arguments.hpp"

#include "settings/configuration_error.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <chrono>
#include <cstddef>
#include <string_view>
#include <variant>

namespace vdrive::canopen {
namespace {

using vdrive::settings::ConfigurationError;

std::vector<TcpAddress> take_addresses(std::string_view option,
                                       const std::vector<std::string>& texts) {
  std::vector<TcpAddress> addresses;
  for (const std::string& text : texts) {
    const auto address = parse_tcp_address(text);
    if (!address) {
      throw ConfigurationError(std::string(option) + " " + in_quotes(text) +
                               ": must be an address and a port, such as 127.0.0.1:29536");
    }
    addresses.push_back(*address);
  }
  return addresses;
}

std::chrono::microseconds take_sync_step(const std::string& text) {
  using std::chrono::nanoseconds;
  const nanoseconds duration = parse_duration(text).value_or(nanoseconds{0});
  const auto step = std::chrono::duration_cast<std::chrono::microseconds>(duration);
  if (step != duration || step < kShortestSyncStep || step > kLongestSyncStep) {
    throw ConfigurationError("--sync-steps " + in_quotes(text) +
                             ": must be a duration from 125us to 10s in whole microseconds");
  }
  return step;
}

ClockMode take_clock(const std::string& text) {
  const std::vector<std::string> modes{std::string(to_string(ClockMode::realtime)),
                                       std::string(to_string(ClockMode::lockstep))};
  if (const std::string refusal = refusal_of_choice(text, modes); !refusal.empty()) {
    throw ConfigurationError("--clock: " + refusal);
  }
  return *clock_mode_named(text);
}

/// @return whether an option describes the private bench.
bool describes_benches(const Arguments& arguments) {
  return arguments.axes || arguments.preset || arguments.bench_configuration;
}

bool names_a_bus(const Arguments& arguments) {
  return !arguments.benches.empty() || !arguments.node_offsets.empty() ||
         !arguments.socketcand.empty() || !arguments.gateways.empty() ||
         !arguments.interfaces.empty() || arguments.log || !arguments.faults.empty() ||
         describes_benches(arguments);
}

/// Gives each bench its offset, or all benches the only one.
void set_offsets(const std::vector<std::int32_t>& offsets, std::vector<BenchSetting>& benches) {
  if (offsets.size() > 1 && offsets.size() != benches.size()) {
    throw ConfigurationError("--node-offset is given " + std::to_string(offsets.size()) +
                             " times for " + counted(benches.size(), "bench", "benches") +
                             ": give it once for all, or once for each --bench");
  }
  if (offsets.empty()) return;
  for (std::size_t place = 0; place < benches.size(); ++place) {
    benches[place].node_offset = offsets.size() == 1 ? offsets[0] : offsets[place];
  }
}

/// @return the benches of the options; a private bus without any gets bench 1.
std::vector<BenchSetting> benches_of(const Arguments& arguments, bool is_private) {
  std::vector<std::uint32_t> numbers = arguments.benches;
  if (numbers.empty() && is_private) numbers.push_back(1);
  std::vector<BenchSetting> benches;
  for (const std::uint32_t number : numbers) {
    BenchSetting& bench = benches.emplace_back();
    bench.number = number;
    bench.axes = arguments.axes;
    bench.preset = arguments.preset.value_or("");
    bench.configuration = arguments.bench_configuration.value_or("");
  }
  set_offsets(arguments.node_offsets, benches);
  return benches;
}

std::vector<BusFault> take_faults(const std::vector<std::string>& texts) {
  if (texts.size() > BusFaults::kMostFaults) {
    throw ConfigurationError("--disturb is given " + std::to_string(texts.size()) +
                             " times: a bus has at most " + std::to_string(BusFaults::kMostFaults) +
                             " faults");
  }
  std::vector<BusFault> faults;
  for (const std::string& text : texts) {
    const auto fault = parse_fault_of_node(text);
    if (const auto* const refusal = std::get_if<std::string>(&fault)) {
      throw ConfigurationError("--disturb " + in_quotes(text) + ": " + *refusal);
    }
    faults.push_back(std::get<BusFault>(fault));
  }
  return faults;
}

void apply_to_bus(const Arguments& arguments, bool is_private, BusSetting& bus) {
  if (!arguments.socketcand.empty()) {
    bus.socketcand = take_addresses("--socketcand", arguments.socketcand);
  }
  if (!arguments.gateways.empty()) bus.gateways = take_addresses("--gateway", arguments.gateways);
  if (!arguments.interfaces.empty()) bus.interfaces = arguments.interfaces;
  if (arguments.log) bus.log = text_of_option("--log", arguments.log);
  if (!arguments.faults.empty()) bus.faults = take_faults(arguments.faults);
  const bool names_benches = !arguments.benches.empty() || describes_benches(arguments);
  // Offsets without benches apply to the benches of the file.
  if (!names_benches && !bus.benches.empty()) {
    return set_offsets(arguments.node_offsets, bus.benches);
  }
  if (!names_benches && arguments.node_offsets.empty()) return;
  bus.benches = benches_of(arguments, is_private);
  if (bus.benches.empty() && !arguments.node_offsets.empty()) {
    bus.node_offset = arguments.node_offsets.front();
  }
}

/// The output files of the program and its bench, apart from the logs of buses.
void apply_files(const Arguments& arguments, Settings& settings) {
  const std::string state = text_of_option("--state", arguments.state);
  const std::string journal = text_of_option("--journal", arguments.journal);
  if (!state.empty()) settings.state = state;
  if (!journal.empty()) settings.journal = journal;
}

}  // namespace

std::string text_of_option(const char* option, const std::optional<std::string>& text) {
  if (!text) return {};
  if (text->empty()) throw ConfigurationError(std::string(option) + ": its value is empty");
  return *text;
}

void apply_arguments(const Arguments& arguments, Settings& settings) {
  const std::string clock = text_of_option("--clock", arguments.clock);
  const std::string sync_steps = text_of_option("--sync-steps", arguments.sync_steps);
  (void)text_of_option("--preset", arguments.preset);
  (void)text_of_option("--bench-config", arguments.bench_configuration);
  const std::string option = arguments.axes ? "--axes" : "--preset";
  if ((arguments.axes || arguments.preset) && arguments.bench_configuration) {
    throw ConfigurationError(option + " and --bench-config are both given: give only one");
  }
  settings.is_private = settings.is_private || arguments.is_private;
  if (describes_benches(arguments) && !settings.is_private) {
    throw ConfigurationError((arguments.bench_configuration ? "--bench-config" : option) +
                             " applies only to a private bench: add --private");
  }
  if (!clock.empty()) settings.clock = take_clock(clock);
  if (!sync_steps.empty()) settings.sync_steps = take_sync_step(sync_steps);
  apply_files(arguments, settings);
  if (!names_a_bus(arguments)) return;
  if (settings.buses.size() > 1) {
    throw ConfigurationError(
        "the file has " + std::to_string(settings.buses.size()) +
        " buses: set the benches and connections of each bus in the file, not on the command line");
  }
  if (settings.buses.empty()) settings.buses.emplace_back();
  apply_to_bus(arguments, settings.is_private, settings.buses.front());
}

}  // namespace vdrive::canopen

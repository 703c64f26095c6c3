// SPDX-License-Identifier: Apache-2.0
#include "configuration/configuration.hpp"

#include "settings/unit_settings.hpp"
#include "settings/yaml_reader.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/plant/model_parameters.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/address.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/ports.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;

constexpr std::int64_t kHighestPort = 65'535;
constexpr std::int64_t kHighestAxisNumber = kAxisNumbers - 1;
constexpr std::int64_t kHighestPriority = 99;
constexpr std::int64_t kLongestDwell = 65'535;

/// The axes of a file, and where they stand, to name the place when the bank refuses one.
struct ParsedAxes {
  std::vector<NamedAxis> axes;
  std::map<std::uint16_t, YamlValue> places;  ///< by axis number
};

/// @return the row that `key` names: a variable_name, the standard's name or an address.
std::optional<ObjectRow> find_row(const std::string& key) {
  const auto object = parse_object(key);
  return object ? find_object(*object) : std::nullopt;
}

bool has_control_characters(std::string_view name) {
  return std::ranges::any_of(name, [](char c) {
    return (c >= '\x00' && c <= '\x1F') || c == '\x7F';
  });
}

std::string checked_name(const YamlValue& value, bool of_axis) {
  std::string name = value.text();
  if (name.empty() || name.size() > kMaxNameLength) {
    value.refuse("a name must have 1 to " + std::to_string(kMaxNameLength) + " bytes");
  }
  if (has_control_characters(name)) value.refuse("a name must not have control characters");
  if (of_axis &&
      (name.find(' ') != std::string::npos || (name.front() >= '0' && name.front() <= '9'))) {
    value.refuse("a name must not contain a blank and must not begin with a digit");
  }
  return name;
}

void read_bench(const YamlValue& value, Configuration& configuration) {
  value.for_each_entry({"number", "name"}, [&](const auto& key, const YamlValue& entry) {
    if (key == "number") {
      configuration.bench = static_cast<std::uint32_t>(entry.integer({1, wire::kHighestBench, ""}));
    } else {
      configuration.name = checked_name(entry, false);
    }
  });
}

double checked_rate(const YamlValue& value) {
  const double rate = value.number("");
  if (rate != 0.0 && (rate < kLowestRate || rate > kHighestRate)) {
    value.refuse("must be 0 (paused) or from " + to_text(kLowestRate) + " to " +
                 to_text(kHighestRate));
  }
  return rate;
}

ClockMode checked_mode(const YamlValue& value) {
  return kClockModes.at(
      value.choice({to_string(ClockMode::realtime), to_string(ClockMode::lockstep),
                    to_string(ClockMode::freerun)}));
}

void read_clock(const YamlValue& value, Configuration& configuration) {
  std::optional<YamlValue> rate;
  value.for_each_entry(
      {"mode", "period_us", "rate", "clock_step", "threads", "realtime_priority"},
      [&](const auto& key, const YamlValue& entry) {
        if (key == "mode") {
          configuration.clock = checked_mode(entry);
        } else if (key == "period_us") {
          configuration.period = std::chrono::microseconds{
              entry.integer({kShortestPeriod.count(), kLongestPeriod.count(), "us"})};
        } else if (key == "rate") {
          configuration.rate = checked_rate(entry);
          rate = entry;
        } else if (key == "clock_step") {
          configuration.clock_step =
              entry.choice({"steer", "jump"}) == 0 ? ClockStep::steer : ClockStep::jump;
        } else if (key == "threads") {
          configuration.threads = static_cast<std::uint32_t>(entry.integer({1, kMaxThreads, ""}));
        } else {
          configuration.realtime_priority =
              static_cast<int>(entry.integer({0, kHighestPriority, ""}));
        }
      });
  if (rate && configuration.clock == ClockMode::freerun) {
    rate->refuse("cannot be used with clock.mode freerun, which runs as fast as possible");
  }
}

void read_watchdog(const YamlValue& value, Configuration& configuration) {
  configuration.watchdog_is_chosen = true;
  value.for_each_entry({"timeout_ms"}, [&](const auto& /*key*/, const YamlValue& entry) {
    if (entry.text() == "off") {
      configuration.watchdog.reset();
    } else {
      configuration.watchdog = std::chrono::milliseconds{
          entry.integer({kShortestWatchdog.count(), kLongestWatchdog.count(), "ms, or off"})};
    }
  });
}

void read_wire(const YamlValue& value, Configuration& configuration) {
  value.for_each_entry({"form", "memory_limit_mib"}, [&](const auto& key, const auto& entry) {
    if (key == "form") {
      constexpr std::array kForms{WireForm::process, WireForm::thread};
      configuration.wire_form =
          kForms.at(entry.choice({to_string(WireForm::process), to_string(WireForm::thread)}));
    } else {
      configuration.wire_memory_limit =
          static_cast<std::uint64_t>(entry.integer({64, 65'536, "MiB"})) << 20U;
    }
  });
}

void read_metrics(const YamlValue& value, Configuration& configuration) {
  value.for_each_entry({"port"}, [&](const auto& /*key*/, const YamlValue& entry) {
    configuration.metrics_port =
        static_cast<std::uint16_t>(entry.integer({0, kHighestPort, ", 0 = any free one"}));
  });
}

std::vector<std::string> read_addresses(const YamlValue& value) {
  std::vector<std::string> addresses;
  value.for_each_element([&](const YamlValue& element) {
    if (!wire::is_address(addresses.emplace_back(element.text()))) {
      element.refuse("must be an IPv4 address, such as 10.0.0.1");
    }
  });
  return addresses;
}

std::vector<std::string> read_servers(const YamlValue& value) {
  std::vector<std::string> servers;
  value.for_each_element([&](const YamlValue& element) {
    if (!wire::parse_server_address(servers.emplace_back(element.text()))) {
      element.refuse("must be an IPv4 address and a port, such as 10.0.0.9:11811");
    }
  });
  return servers;
}

std::string checked_directory(const YamlValue& value) {
  std::string directory = value.text();
  if (directory.empty()) {
    value.refuse("must name a directory; leave out this key for an open bench");
  }
  return directory;
}

void read_network(const YamlValue& value, wire::NetworkSettings& network) {
  value.for_each_entry(
      {"domain", "interfaces", "peers", "discovery_server", "shared_memory", "security"},
      [&](const auto& key, const YamlValue& entry) {
        if (key == "domain") {
          network.domain = static_cast<std::uint32_t>(entry.integer({0, wire::kHighestDomain, ""}));
        } else if (key == "interfaces") {
          network.interfaces = read_addresses(entry);
        } else if (key == "peers") {
          network.peers = read_addresses(entry);
        } else if (key == "discovery_server") {
          network.discovery_servers = read_servers(entry);
        } else if (key == "security") {
          network.security = checked_directory(entry);
        } else {
          network.shared_memory = entry.boolean();
        }
      });
  if (!network.peers.empty() && !network.discovery_servers.empty()) {
    value.refuse("peers and discovery servers cannot be used together: name only one kind");
  }
}

const ModelParameter& model_parameter(const std::string& key, const YamlValue& value) {
  const auto* const parameter = std::ranges::find_if(kModelParameters, [&](const auto& candidate) {
    return candidate.name == key;
  });
  if (parameter == kModelParameters.end()) {
    std::string known = "coupling, feedback";
    for (const auto& candidate : kModelParameters) known += ", " + std::string(candidate.name);
    value.refuse("unknown key; known here: " + known);
  }
  return *parameter;
}

void read_model(const YamlValue& value, AxisModel& model) {
  std::vector<std::pair<const ModelParameter*, YamlValue>> numbers;
  value.for_each_entry({}, [&](const auto& key, const YamlValue& entry) {
    if (key == "coupling") {
      model.coupling =
          entry.choice({"rigid", "two_inertia"}) == 0 ? Coupling::rigid : Coupling::two_inertia;
    } else if (key == "feedback") {
      model.feedback = entry.choice({"single_encoder", "dual_encoder"}) == 0
                           ? Feedback::single_encoder
                           : Feedback::dual_encoder;
    } else {
      const ModelParameter& parameter = model_parameter(key, entry);
      model.*parameter.member = entry.number(parameter.unit);
      numbers.emplace_back(&parameter, entry);
    }
  });
  // The limits depend on the coupling, which may stand below the numbers.
  for (const auto& [parameter, entry] : numbers) {
    if (const auto limits = limits_broken(model, *parameter)) entry.refuse(*limits);
  }
}

void read_settings(const YamlValue& value, AxisSettings& settings) {
  value.for_each_entry({"acknowledge_while_halted", "enable_from_switch_on_disabled",
                        "following_error_is_fault", "limits_need_homing", "quick_stop_dwell_ms"},
                       [&](const auto& key, const YamlValue& entry) {
                         if (key == "acknowledge_while_halted") {
                           settings.acknowledge_while_halted = entry.boolean();
                         } else if (key == "enable_from_switch_on_disabled") {
                           settings.enable_from_switch_on_disabled = entry.boolean();
                         } else if (key == "following_error_is_fault") {
                           settings.following_error_is_fault = entry.boolean();
                         } else if (key == "limits_need_homing") {
                           settings.limits_need_homing = entry.boolean();
                         } else {
                           settings.quick_stop_dwell_ms =
                               static_cast<std::uint16_t>(entry.integer({0, kLongestDwell, "ms"}));
                         }
                       });
}

/// A value of `parameters`, and where it stands.
struct PlacedValue {
  std::int64_t value;
  YamlValue place;
};

/// The drive takes every value of each limit, and has none while they are in the wrong order.
void check_software_limits(const std::map<ObjectAddress, PlacedValue>& values) {
  const auto lower = values.find(describe("user_position_lower_limit"_object).address);
  const auto upper = values.find(describe("user_position_upper_limit"_object).address);
  if (lower == values.end() || upper == values.end()) return;
  if (lower->second.value < upper->second.value) return;
  lower->second.place.refuse("must be below user_position_upper_limit (607Dh:2) = " +
                             std::to_string(upper->second.value));
}

/// What a write of an object does besides keeping its value; empty = nothing.
std::string_view effect_of(const ObjectDescription& object) {
  if (object.role == Role::command) return "commands the axis";
  if (object.change == Change::memory) return "stores or restores parameters";
  return object.change == Change::history ? "clears the error history" : "";
}

/// What acts when it is written has no value from power-up on.
void check_is_parameter(const ObjectDescription& object, const YamlValue& value) {
  const std::string_view effect = effect_of(object);
  if (effect.empty()) return;
  value.refuse(std::string(object.variable_name) + " (" + address_text(object.address) +
               ") is no parameter: a write of it " + std::string(effect) +
               "; parameters are objects that keep a value, such as profile_velocity, and test "
               "inputs, such as test_load_torque");
}

void read_parameters(const YamlValue& value, std::vector<InitialValue>& parameters) {
  std::map<ObjectAddress, PlacedValue> values;
  value.for_each_entry({}, [&](const auto& key, const YamlValue& entry) {
    const auto row = find_row(key);
    if (!row) entry.refuse(R"(no such object; write its variable_name, "0x6081" or "0x607D:1")");
    const ObjectDescription& object = describe(*row);
    check_is_parameter(object, entry);
    const std::string units = object.units == "-" ? std::string() : english_units(object);
    const std::int64_t number = entry.integer({object.lower_limit, object.upper_limit, units});
    if (const AbortCode code = check_write(*row, number); code != AbortCode::none) {
      entry.refuse(std::string(describe(code)));
    }
    const auto [first, is_first] = values.emplace(object.address, PlacedValue{number, entry});
    if (!is_first) {
      entry.refuse("the same object, " + address_text(object.address) + ", has the value " +
                   std::to_string(first->second.value) + " in line " +
                   std::to_string(first->second.place.line()));
    }
    parameters.push_back({object.address, number});
  });
  check_software_limits(values);
}

NamedAxis read_axis(const YamlValue& value) {
  NamedAxis axis;
  value.for_each_entry(
      {"number", "name", "unit", "initial_position", "settings", "model", "parameters"},
      [&](const auto& key, const YamlValue& entry) {
        auto& configuration = axis.configuration;
        if (key == "number") {
          axis.number = static_cast<std::uint16_t>(entry.integer({1, kHighestAxisNumber, ""}));
        } else if (key == "name") {
          axis.name = checked_name(entry, true);
        } else if (key == "unit") {
          axis.unit = read_unit(entry);
        } else if (key == "initial_position") {
          configuration.initial_position = static_cast<std::int32_t>(
              entry.integer({std::numeric_limits<std::int32_t>::min(),
                             std::numeric_limits<std::int32_t>::max(), "user units"}));
        } else if (key == "settings") {
          read_settings(entry, configuration.settings);
        } else if (key == "model") {
          read_model(entry, configuration.model);
        } else {
          read_parameters(entry, configuration.parameters);
        }
      });
  if (axis.number == 0) value.refuse("an axis needs a number");
  if (axis.name.empty()) axis.name = "axis" + std::to_string(axis.number);
  return axis;
}

ParsedAxes read_axes(const YamlValue& value) {
  ParsedAxes parsed;
  std::set<std::string> names;
  value.for_each_element([&](const YamlValue& element) {
    const NamedAxis& axis = parsed.axes.emplace_back(read_axis(element));
    if (!parsed.places.emplace(axis.number, element).second) {
      element.refuse("axis number " + std::to_string(axis.number) + " appears twice");
    }
    if (!names.insert(axis.name).second) {
      element.refuse("axis name " + escaped(axis.name) + " appears twice");
    }
    if (parsed.axes.size() > kMaxAxes) {
      element.refuse("a bench can have at most " + std::to_string(kMaxAxes) + " axes");
    }
  });
  if (parsed.axes.empty()) value.refuse("a bench needs at least one axis");
  std::ranges::sort(parsed.axes, [](const auto& a, const auto& b) {
    return a.number < b.number;
  });
  return parsed;
}

/// The bank knows rules that no single value shows: it tries each axis alone.
void try_axes(const ParsedAxes& parsed, std::chrono::microseconds period) {
  for (const auto& axis : parsed.axes) {
    try {
      const AxisBank bank(std::span(&axis.configuration, 1), period);
    } catch (const std::invalid_argument& refusal) {
      parsed.places.at(axis.number)
          .refuse("axis " + std::to_string(axis.number) + ": " + refusal.what());
    }
  }
}

Configuration read_configuration(const YamlValue& root) {
  Configuration configuration = demo_configuration();
  ParsedAxes parsed;
  root.for_each_entry(
      {"bench", "clock", "status", "watchdog", "metrics", "wire", "network", "axes"},
      [&](const auto& key, const YamlValue& entry) {
        if (key == "bench") {
          read_bench(entry, configuration);
        } else if (key == "clock") {
          read_clock(entry, configuration);
        } else if (key == "status") {
          entry.for_each_entry({"every_ticks"}, [&](const auto&, const auto& every) {
            configuration.status_every =
                static_cast<std::uint32_t>(every.integer({1, kMaxStatusEvery, "ticks"}));
          });
        } else if (key == "watchdog") {
          read_watchdog(entry, configuration);
        } else if (key == "metrics") {
          read_metrics(entry, configuration);
        } else if (key == "wire") {
          read_wire(entry, configuration);
        } else if (key == "network") {
          read_network(entry, configuration.network);
        } else {
          parsed = read_axes(entry);
        }
      });
  try_axes(parsed, configuration.period);
  if (!parsed.axes.empty()) configuration.axes = std::move(parsed.axes);
  return configuration;
}

void check_range(const char* what, double value, double lowest, double highest, const char* unit) {
  if (!(value >= lowest && value <= highest)) {
    throw ConfigurationError(std::string(what) + " = " + to_text(value) + ": must be from " +
                             to_text(lowest) + " to " + to_text(highest) + unit);
  }
}

// ---- writing -----------------------------------------------------------------------------------

void write_settings(YAML::Emitter& out, const AxisSettings& settings) {
  out << YAML::Key << "settings" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "acknowledge_while_halted" << YAML::Value
      << settings.acknowledge_while_halted;
  out << YAML::Key << "enable_from_switch_on_disabled" << YAML::Value
      << settings.enable_from_switch_on_disabled;
  out << YAML::Key << "following_error_is_fault" << YAML::Value
      << settings.following_error_is_fault;
  out << YAML::Key << "limits_need_homing" << YAML::Value << settings.limits_need_homing;
  out << YAML::Key << "quick_stop_dwell_ms" << YAML::Value << settings.quick_stop_dwell_ms;
  out << YAML::EndMap;
}

void write_model(YAML::Emitter& out, const AxisModel& model) {
  out << YAML::Key << "model" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "coupling" << YAML::Value
      << (model.coupling == Coupling::rigid ? "rigid" : "two_inertia");
  out << YAML::Key << "feedback" << YAML::Value
      << (model.feedback == Feedback::single_encoder ? "single_encoder" : "dual_encoder");
  for (const auto& parameter : kModelParameters) {
    out << YAML::Key << std::string(parameter.name) << YAML::Value
        << to_text(model.*parameter.member);
  }
  out << YAML::EndMap;
}

/// @return such as "profile_velocity [VelUU]".
std::string comment_on(ObjectRow row) {
  const ObjectDescription& object = describe(row);
  std::string comment(object.variable_name);
  if (object.units != "-") comment += " [" + english_units(object) + "]";
  return comment;
}

void write_axis(YAML::Emitter& out, const NamedAxis& axis) {
  out << YAML::BeginMap << YAML::Key << "number" << YAML::Value << axis.number;
  out << YAML::Key << "name" << YAML::Value << axis.name;
  write_unit(out, axis.unit);
  out << YAML::Key << "initial_position" << YAML::Value << axis.configuration.initial_position;
  write_settings(out, axis.configuration.settings);
  write_model(out, axis.configuration.model);
  if (!axis.configuration.parameters.empty()) {
    out << YAML::Key << "parameters" << YAML::Value << YAML::BeginMap;
    for (const auto& parameter : axis.configuration.parameters) {
      out << YAML::Key << YAML::DoubleQuoted << address_text(parameter.address) << YAML::Value
          << parameter.value;
      if (const auto row = find_object(parameter.address)) out << YAML::Comment(comment_on(*row));
    }
    out << YAML::EndMap;
  }
  out << YAML::EndMap;
}

void write_clock(YAML::Emitter& out, const Configuration& configuration) {
  out << YAML::Key << "clock" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "mode" << YAML::Value << std::string(to_string(configuration.clock));
  out << YAML::Key << "period_us" << YAML::Value << configuration.period.count();
  if (configuration.clock != ClockMode::freerun) {
    out << YAML::Key << "rate" << YAML::Value << to_text(configuration.rate);
  }
  out << YAML::Key << "clock_step" << YAML::Value
      << (configuration.clock_step == ClockStep::steer ? "steer" : "jump");
  out << YAML::Key << "threads" << YAML::Value << configuration.threads;
  out << YAML::Key << "realtime_priority" << YAML::Value << configuration.realtime_priority;
  out << YAML::EndMap;
}

void write_network(YAML::Emitter& out, const wire::NetworkSettings& network) {
  out << YAML::Key << "network" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "domain" << YAML::Value << network.domain;
  out << YAML::Key << "interfaces" << YAML::Value << YAML::Flow << network.interfaces;
  out << YAML::Key << "peers" << YAML::Value << YAML::Flow << network.peers;
  out << YAML::Key << "discovery_server" << YAML::Value << YAML::Flow << network.discovery_servers;
  out << YAML::Key << "shared_memory" << YAML::Value << network.shared_memory;
  if (!network.security.empty()) {
    out << YAML::Key << "security" << YAML::Value << YAML::DoubleQuoted << network.security;
  }
  out << YAML::EndMap;
}

/// Threads are for programs of this host that need no credentials: what others send can end the
/// wire.
WireForm default_wire_form(const Configuration& configuration) noexcept {
  const wire::NetworkSettings& network = configuration.network;
  if (network.shared_memory) return WireForm::thread;  // the process form must not open files
  // Peers and discovery servers are hosts to send to; who can send here depends on the interfaces.
  const bool is_local = std::ranges::all_of(network.interfaces, &wire::is_loopback);
  const bool needs_process =
      configuration.clock == ClockMode::realtime || !network.security.empty() || !is_local;
  return needs_process ? WireForm::process : WireForm::thread;
}

}  // namespace

Configuration demo_configuration() {
  Configuration configuration;
  configuration.axes = default_axes(2);
  configuration.axes[0].name = "x";
  configuration.axes[1].name = "y";
  return configuration;
}

std::vector<NamedAxis> default_axes(std::size_t count) {
  if (count < 1 || count > kMaxAxes) {
    throw ConfigurationError("axes = " + std::to_string(count) + ": must be from 1 to " +
                             std::to_string(kMaxAxes));
  }
  std::vector<NamedAxis> axes(count);
  for (std::size_t index = 0; index < count; ++index) {
    axes[index].number = static_cast<std::uint16_t>(index + 1);
    axes[index].name = "axis" + std::to_string(index + 1);
  }
  return axes;
}

Configuration parse_configuration(const std::string& text, const std::string& file_name) {
  const YAML::Node document = read_yaml(text, file_name);
  if (document.IsNull()) return demo_configuration();
  return read_configuration(YamlValue(document, file_name, ""));
}

Configuration load_configuration(const std::filesystem::path& file) {
  return parse_configuration(read_yaml_file(file), file.string());
}

void check(const Configuration& configuration) {
  check_range("bench", configuration.bench, 1, wire::kHighestBench, "");
  check_range("period", static_cast<double>(configuration.period.count()),
              static_cast<double>(kShortestPeriod.count()),
              static_cast<double>(kLongestPeriod.count()), " us");
  if (configuration.rate != 0.0) {
    check_range("rate", configuration.rate, kLowestRate, kHighestRate, ", or 0 = paused");
  }
  check_range("threads", configuration.threads, 1, kMaxThreads, "");
  check_range("domain", configuration.network.domain, 0, wire::kHighestDomain, "");
  check_range("status.every_ticks", configuration.status_every, 1, kMaxStatusEvery, " ticks");
  check_range("axes", static_cast<double>(configuration.axes.size()), 1, kMaxAxes, "");
  if (configuration.wire_form == WireForm::process && configuration.network.shared_memory) {
    throw ConfigurationError(
        "wire.form = process cannot be combined with network.shared_memory = true: the network "
        "process must not open files, and shared memory needs files; use wire.form: thread");
  }
  if (configuration.watchdog) {
    check_range("watchdog", static_cast<double>(configuration.watchdog->count()),
                static_cast<double>(kShortestWatchdog.count()),
                static_cast<double>(kLongestWatchdog.count()), " ms");
  }
}

std::string to_yaml(const Configuration& configuration) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  out << YAML::Key << "bench" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "number" << YAML::Value << configuration.bench;
  out << YAML::Key << "name" << YAML::Value << configuration.name << YAML::EndMap;
  write_clock(out, configuration);
  out << YAML::Key << "status" << YAML::Value << YAML::BeginMap << YAML::Key << "every_ticks"
      << YAML::Value << configuration.status_every << YAML::EndMap;
  out << YAML::Key << "watchdog" << YAML::Value << YAML::BeginMap << YAML::Key << "timeout_ms"
      << YAML::Value;
  if (const auto watchdog = effective_watchdog(configuration)) {
    out << watchdog->count();
  } else {
    out << "off";
  }
  out << YAML::EndMap;
  out << YAML::Key << "wire" << YAML::Value << YAML::BeginMap << YAML::Key << "form" << YAML::Value
      << std::string(to_string(effective_wire_form(configuration))) << YAML::Key
      << "memory_limit_mib" << YAML::Value << (configuration.wire_memory_limit >> 20U)
      << YAML::EndMap;
  if (configuration.metrics_port) {
    out << YAML::Key << "metrics" << YAML::Value << YAML::BeginMap << YAML::Key << "port"
        << YAML::Value << *configuration.metrics_port << YAML::EndMap;
  }
  write_network(out, configuration.network);
  out << YAML::Key << "axes" << YAML::Value << YAML::BeginSeq;
  for (const auto& axis : configuration.axes) write_axis(out, axis);
  out << YAML::EndSeq << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

std::string_view to_string(WireForm form) noexcept {
  return form == WireForm::process ? "process" : "thread";
}

std::optional<WireForm> wire_form_named(std::string_view name) noexcept {
  if (name == to_string(WireForm::process)) return WireForm::process;
  return name == to_string(WireForm::thread) ? std::optional(WireForm::thread) : std::nullopt;
}

WireForm effective_wire_form(const Configuration& configuration) noexcept {
  return configuration.wire_form.value_or(default_wire_form(configuration));
}

std::optional<std::chrono::milliseconds> effective_watchdog(
    const Configuration& configuration) noexcept {
  const bool is_default = !configuration.watchdog_is_chosen;
  return configuration.clock == ClockMode::freerun && is_default ? std::nullopt
                                                                 : configuration.watchdog;
}

std::vector<AxisConfiguration> bank_axes(const Configuration& configuration) {
  std::vector<AxisConfiguration> axes;
  axes.reserve(configuration.axes.size());
  for (const auto& axis : configuration.axes) {
    axes.push_back(axis.configuration);
    axes.back().serial_number = configuration.bench * 65'536U + axis.number;
  }
  return axes;
}

}  // namespace vdrive::service

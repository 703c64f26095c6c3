// SPDX-License-Identifier: Apache-2.0
// The keys of a configuration, section by section.
#include "configuration/configuration_keys.hpp"

#include "configuration/axis_warnings.hpp"
#include "configuration/mechanics.hpp"
#include "settings/configuration_error.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/address.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/ports.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <string_view>

namespace vdrive::service {
namespace {

constexpr std::int64_t kHighestPort = 65'535;
constexpr std::int64_t kHighestPriority = 99;

bool has_control_characters(std::string_view name) {
  return std::ranges::any_of(name, [](char c) {
    return (c >= '\x00' && c <= '\x1F') || c == '\x7F';
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

/// Here and not in the rows of the keys: the mode may stand below them.
void refuse_keys_of_other_modes(const YamlValue& clock, const Configuration& configuration) {
  clock.for_each_entry({}, [&](const std::string& key, const YamlValue& value) {
    if (const auto problem = problem_of_clock(key, configuration)) {
      value.refuse("cannot be used with clock.mode " + *problem);
    }
  });
}

void read_timeout(const YamlValue& value, Configuration& configuration);

void write_timeout(YAML::Emitter& out, const Configuration& configuration) {
  if (const auto watchdog = effective_watchdog(configuration)) {
    out << watchdog->count();
  } else {
    out << "off";
  }
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

void check_network(const YamlValue& value, const wire::NetworkSettings& network) {
  if (!network.peers.empty() && !network.discovery_servers.empty()) {
    value.refuse("peers and discovery servers cannot be used together: name only one kind");
  }
}

template <typename Owner, const auto& kRows>
void describe_rows(const std::string& prefix, std::vector<ConfigurationKey>& keys) {
  describe_section<Owner>(prefix + ".", kRows, keys);
}

/// Keys of an axis that are read last, in this order: what `mechanics` gives depends on the model,
/// and the others may be written in the unit that follows from it.
constexpr std::array<std::string_view, 3> kLastKeys{"mechanics", "initial_position", "parameters"};

bool is_read_last(std::string_view key) {
  return std::ranges::find(kLastKeys, key) != kLastKeys.end();
}

/// What is written in a unit is not judged by a wrong one. From the gear of the model it follows
/// with the mechanics only.
/// @param wrong keys of the axis whose values are refused
bool is_unit_known(const std::set<std::string>& wrong, bool has_mechanics) {
  return !wrong.contains("unit") && !wrong.contains("mechanics") &&
         !(has_mechanics && wrong.contains("model"));
}

/// `mechanics` decides the unit of its axis.
void check_unit(const YamlValue& place, const Unit& written, const Unit& unit) {
  if (written == unit) return;
  place.refuse("contradicts mechanics, from which {kind: " + std::string(to_string(unit.kind)) +
               ", name: " + unit.name +
               (unit.kind == UnitKind::linear ? ", per_unit: " : ", per_revolution: ") +
               to_text(unit.size) + "} follows; leave it out");
}

void name_axis(const YamlValue& value, NamedAxis& axis) {
  if (axis.number == 0) value.refuse("an axis needs a number");
  if (axis.name.empty()) axis.name = "axis" + std::to_string(axis.number);
}

NamedAxis read_axis(const YamlValue& value) {
  NamedAxis axis;
  AxisEntries entries;
  settings::Mistakes mistakes;
  std::set<std::string> wrong;
  const auto read = [&](const std::string& key, const YamlValue& entry) {
    const bool is_good = mistakes.collect([&] {
      read_key(row_of_known(axis_rows(), key), entry, axis);
    });
    if (!is_good) wrong.insert(key);
  };
  mistakes.collect([&] {
    value.for_each_entry(keys_of(axis_rows()), [&](const std::string& key, const YamlValue& entry) {
      entries.emplace(key, entry);
      if (!is_read_last(key)) read(key, entry);
    });
  });
  const Unit written = axis.unit;
  const bool has_mechanics = entries.contains("mechanics");
  for (const std::string_view key : kLastKeys) {
    const auto entry = entries.find(std::string(key));
    if (entry != entries.end() && is_unit_known(wrong, has_mechanics)) {
      read(entry->first, entry->second);
    }
  }
  mistakes.throw_if_any();
  if (has_mechanics) {
    if (const auto unit = entries.find("unit"); unit != entries.end()) {
      check_unit(unit->second, written, axis.unit);
    }
    complete_speeds(axis.configuration);
  }
  name_axis(value, axis);
  axis.warnings = axis_warnings(axis, entries);
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
    if (parsed.axes.size() == kMaxAxes + 1) {
      element.refuse("a bench can have at most " + std::to_string(kMaxAxes) + " axes");
    }
  });
  if (parsed.axes.empty()) value.refuse("a bench needs at least one axis");
  std::ranges::sort(parsed.axes, [](const auto& a, const auto& b) {
    return a.number < b.number;
  });
  return parsed;
}

void write_axes(YAML::Emitter& out, const std::vector<NamedAxis>& axes) {
  out << YAML::BeginSeq;
  for (const NamedAxis& axis : axes) write_section(out, axis_rows(), axis);
  out << YAML::EndSeq;
}

constexpr auto kBenchRows = std::to_array<ConfigurationRow<Configuration>>({
    integer_row<Configuration, &Configuration::bench>("number", {1, wire::kHighestBench, ""},
                                                      "{}, unique in its DDS domain."),
    {.key = "name",
     .what = "1 to 64 bytes of UTF-8 without control characters.",
     .read =
         [](const YamlValue& value, Configuration& c) {
           c.name = checked_name(value, false);
         },
     .write =
         [](YAML::Emitter& out, const Configuration& c) {
           out << c.name;
         }},
});

constexpr auto kClockRows = std::to_array<ConfigurationRow<Configuration>>({
    {.key = "mode",
     .what = "realtime: by the wall clock; lockstep: by steps of clients; freerun: as fast as "
             "possible.",
     .read =
         [](const YamlValue& value, Configuration& c) {
           c.clock = checked_mode(value);
         },
     .write =
         [](YAML::Emitter& out, const Configuration& c) {
           out << std::string(to_string(c.clock));
         }},
    {.key = "period_us",
     .what = "Length of a tick, {} us.",
     .limits = IntegerLimits{kShortestPeriod.count(), kLongestPeriod.count(), "us"},
     .set =
         [](Configuration& c, std::int64_t value) {
           c.period = std::chrono::microseconds{value};
         },
     .write =
         [](YAML::Emitter& out, const Configuration& c) {
           out << c.period.count();
         }},
    {.key = "rate",
     .what =
         "realtime: drive time over wall time, 0 (paused) or 0.1 to 100. Refused with the other "
         "modes.",
     .read =
         [](const YamlValue& value, Configuration& c) {
           c.rate = checked_rate(value);
         },
     .write =
         [](YAML::Emitter& out, const Configuration& c) {
           out << to_text(c.rate);
         },
     .is_printed =
         [](const Configuration& c) {
           return c.clock == ClockMode::realtime;
         }},
    integer_row<Configuration, &Configuration::steppers>(
        "steppers", {0, kMaxSteppers, ""},
        "lockstep: time begins to pass once so many programs have joined the clock, {}; 0: it "
        "waits for none."),
    {.key = "clock_step",
     .what = "realtime at rate 1, after a change of the wall clock: steer (slowly, by 500 ppm) or "
             "jump (at once, forward only).",
     .read =
         [](const YamlValue& value, Configuration& c) {
           c.clock_step =
               value.choice({"steer", "jump"}) == 0 ? WallStepPolicy::steer : WallStepPolicy::jump;
         },
     .write =
         [](YAML::Emitter& out, const Configuration& c) {
           out << (c.clock_step == WallStepPolicy::steer ? "steer" : "jump");
         }},
    integer_row<Configuration, &Configuration::threads>(
        "threads", {1, kMaxThreads, ""},
        "Threads that step the axes, {}. The result is the same for any number."),
    integer_row<Configuration, &Configuration::realtime_priority>(
        "realtime_priority", {0, kHighestPriority, ""},
        "SCHED_FIFO of the thread of the ticks where permitted, {}; 0: none."),
});

constexpr auto kStatusRows = std::to_array<ConfigurationRow<Configuration>>({
    integer_row<Configuration, &Configuration::status_every>(
        "every_ticks", {1, kMaxStatusEvery, "ticks"}, "One status frame each n ticks, {}."),
});

constexpr auto kWatchdogRows = std::to_array<ConfigurationRow<Configuration>>({
    {.key = "timeout_ms",
     .what = "The owner of an axis must send at least this often: {} ms of drive time (at a rate "
             "above 1 of wall time), or off. Off in freerun unless the key is set.",
     .limits = IntegerLimits{kShortestWatchdog.count(), kLongestWatchdog.count(), "ms, or off"},
     .read =
         [](const YamlValue& value, Configuration& c) {
           read_timeout(value, c);
         },
     .write =
         [](YAML::Emitter& out, const Configuration& c) {
           write_timeout(out, c);
         }},
});

void read_timeout(const YamlValue& value, Configuration& configuration) {
  if (value.text() == "off") {
    configuration.watchdog.reset();
  } else {
    configuration.watchdog = std::chrono::milliseconds{value.integer(*kWatchdogRows[0].limits)};
  }
}

constexpr auto kWireRows = std::to_array<ConfigurationRow<Configuration>>({
    {.key = "form",
     .what = "Where DDS runs: in a process, which the service restarts when it fails, or in a "
             "thread of the service. Default: process in realtime, with network.security and with "
             "an interface other than loopback; thread otherwise and with shared memory.",
     .read =
         [](const YamlValue& value, Configuration& c) {
           constexpr std::array kForms{WireForm::process, WireForm::thread};
           c.wire_form =
               kForms.at(value.choice({to_string(WireForm::process), to_string(WireForm::thread)}));
         },
     .write =
         [](YAML::Emitter& out, const Configuration& c) {
           out << std::string(to_string(effective_wire_form(c)));
         }},
    {.key = "memory_limit_mib",
     .what = "Of the network process, {} MiB: one that uses more is restarted.",
     .limits = IntegerLimits{64, 65'536, "MiB"},
     .set =
         [](Configuration& c, std::int64_t value) {
           c.wire_memory_limit = static_cast<std::uint64_t>(value) << 20U;
         },
     .write =
         [](YAML::Emitter& out, const Configuration& c) {
           out << (c.wire_memory_limit >> 20U);
         }},
});

constexpr auto kMetricsRows = std::to_array<ConfigurationRow<Configuration>>({
    {.key = "port",
     .what = "Prometheus text on this port of 127.0.0.1, {}; 0: any free one. Without the key "
             "there are no metrics.",
     .limits = IntegerLimits{0, kHighestPort, ", 0 = any free one"},
     .set =
         [](Configuration& c, std::int64_t value) {
           c.metrics_port = static_cast<std::uint16_t>(value);
         },
     .write =
         [](YAML::Emitter& out, const Configuration& c) {
           out << *c.metrics_port;
         }},
});

constexpr auto kNetworkRows = std::to_array<ConfigurationRow<wire::NetworkSettings>>({
    integer_row<wire::NetworkSettings, &wire::NetworkSettings::domain>(
        "domain", {0, wire::kHighestDomain, ""}, "DDS domain, {}."),
    {.key = "interfaces",
     .what = "List of IPv4 addresses of this machine in the networks to serve; empty: this machine "
             "only.",
     .read =
         [](const YamlValue& value, wire::NetworkSettings& c) {
           c.interfaces = read_addresses(value);
         },
     .write =
         [](YAML::Emitter& out, const wire::NetworkSettings& c) {
           out << YAML::Flow << c.interfaces;
         }},
    {.key = "peers",
     .what = "List of IPv4 addresses of hosts that are searched in addition to multicast.",
     .read =
         [](const YamlValue& value, wire::NetworkSettings& c) {
           c.peers = read_addresses(value);
         },
     .write =
         [](YAML::Emitter& out, const wire::NetworkSettings& c) {
           out << YAML::Flow << c.peers;
         }},
    {.key = "discovery_server",
     .what = "List of servers, such as 10.0.0.9:11811, used instead of multicast and peers.",
     .read =
         [](const YamlValue& value, wire::NetworkSettings& c) {
           c.discovery_servers = read_servers(value);
         },
     .write =
         [](YAML::Emitter& out, const wire::NetworkSettings& c) {
           out << YAML::Flow << c.discovery_servers;
         }},
    boolean_row<wire::NetworkSettings, &wire::NetworkSettings::shared_memory>(
        "shared_memory", "true: DDS uses shared memory, too, and runs in threads of the service."),
    {.key = "security",
     .what = "Directory of the closed mode's material. Without the key the bench is open.",
     .read =
         [](const YamlValue& value, wire::NetworkSettings& c) {
           c.security = checked_directory(value);
         },
     .write =
         [](YAML::Emitter& out, const wire::NetworkSettings& c) {
           out << YAML::DoubleQuoted << c.security;
         },
     .is_printed =
         [](const wire::NetworkSettings& c) {
           return !c.security.empty();
         }},
});

constexpr auto kRootRows = std::to_array<ConfigurationRow<ParsedConfiguration>>({
    {.key = "bench",
     .read =
         [](const YamlValue& value, ParsedConfiguration& c) {
           read_section<Configuration>(value, kBenchRows, c.configuration);
         },
     .write =
         [](YAML::Emitter& out, const ParsedConfiguration& c) {
           write_section<Configuration>(out, kBenchRows, c.configuration);
         },
     .describe = describe_rows<Configuration, kBenchRows>},
    {.key = "clock",
     .read =
         [](const YamlValue& value, ParsedConfiguration& c) {
           read_section<Configuration>(value, kClockRows, c.configuration);
           refuse_keys_of_other_modes(value, c.configuration);
         },
     .write =
         [](YAML::Emitter& out, const ParsedConfiguration& c) {
           write_section<Configuration>(out, kClockRows, c.configuration);
         },
     .describe = describe_rows<Configuration, kClockRows>},
    {.key = "status",
     .read =
         [](const YamlValue& value, ParsedConfiguration& c) {
           read_section<Configuration>(value, kStatusRows, c.configuration);
         },
     .write =
         [](YAML::Emitter& out, const ParsedConfiguration& c) {
           write_section<Configuration>(out, kStatusRows, c.configuration);
         },
     .describe = describe_rows<Configuration, kStatusRows>},
    {.key = "watchdog",
     .read =
         [](const YamlValue& value, ParsedConfiguration& c) {
           read_section<Configuration>(value, kWatchdogRows, c.configuration);
           c.configuration.watchdog_is_chosen = true;
         },
     .write =
         [](YAML::Emitter& out, const ParsedConfiguration& c) {
           write_section<Configuration>(out, kWatchdogRows, c.configuration);
         },
     .describe = describe_rows<Configuration, kWatchdogRows>},
    {.key = "wire",
     .read =
         [](const YamlValue& value, ParsedConfiguration& c) {
           read_section<Configuration>(value, kWireRows, c.configuration);
         },
     .write =
         [](YAML::Emitter& out, const ParsedConfiguration& c) {
           write_section<Configuration>(out, kWireRows, c.configuration);
         },
     .describe = describe_rows<Configuration, kWireRows>},
    {.key = "metrics",
     .read =
         [](const YamlValue& value, ParsedConfiguration& c) {
           read_section<Configuration>(value, kMetricsRows, c.configuration);
         },
     .write =
         [](YAML::Emitter& out, const ParsedConfiguration& c) {
           write_section<Configuration>(out, kMetricsRows, c.configuration);
         },
     .is_printed =
         [](const ParsedConfiguration& c) {
           return c.configuration.metrics_port.has_value();
         },
     .describe = describe_rows<Configuration, kMetricsRows>},
    {.key = "network",
     .read =
         [](const YamlValue& value, ParsedConfiguration& c) {
           read_section<wire::NetworkSettings>(value, kNetworkRows, c.configuration.network);
           check_network(value, c.configuration.network);
         },
     .write =
         [](YAML::Emitter& out, const ParsedConfiguration& c) {
           write_section<wire::NetworkSettings>(out, kNetworkRows, c.configuration.network);
         },
     .describe = describe_rows<wire::NetworkSettings, kNetworkRows>},
    {.key = "axes",
     .read =
         [](const YamlValue& value, ParsedConfiguration& c) {
           c.axes = read_axes(value);
         },
     .write =
         [](YAML::Emitter& out, const ParsedConfiguration& c) {
           write_axes(out, c.configuration.axes);
         },
     .describe =
         [](const std::string& prefix, std::vector<ConfigurationKey>& keys) {
           describe_section(prefix + "[].", axis_rows(), keys);
         }},
});

}  // namespace

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

std::span<const ConfigurationRow<ParsedConfiguration>> configuration_rows() noexcept {
  return kRootRows;
}

}  // namespace vdrive::service

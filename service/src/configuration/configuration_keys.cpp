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

using settings::Any;
using settings::IntegerLimits;
using settings::IntegerOrNone;
using settings::key;
using settings::kOneOf;
using settings::Row;
using settings::Rule;
using settings::section;
using settings::TextRule;

constexpr std::int64_t kHighestPort = 65'535;
constexpr std::int64_t kHighestPriority = 99;

bool has_control_characters(std::string_view name) {
  return std::ranges::any_of(name, [](char c) {
    return (c >= '\x00' && c <= '\x1F') || c == '\x7F';
  });
}

void check_bench_name(const YamlValue& value, Configuration& configuration) {
  check_name(value, configuration.name);
}

void check_rate(const YamlValue& value, Configuration& configuration) {
  const double rate = configuration.rate;
  if (rate != 0.0 && (rate < kLowestRate || rate > kHighestRate)) {
    value.refuse("must be 0 (paused) or from " + to_text(kLowestRate) + " to " +
                 to_text(kHighestRate));
  }
}

bool has_rate(const Configuration& configuration) {
  return !problem_of_clock("rate", configuration);
}

bool has_metrics(const Configuration& configuration) {
  return configuration.metrics_port.has_value();
}

/// Checked here and not in the rows of the keys, because the mode may come after them in the file.
void refuse_keys_of_other_modes(const YamlValue& clock, ParsedConfiguration& parsed) {
  clock.for_each_entry({}, [&](const std::string& key, const YamlValue& value) {
    if (const auto problem = problem_of_clock(key, parsed.configuration)) {
      value.refuse("cannot be used with clock.mode " + *problem);
    }
  });
}

void choose_watchdog(const YamlValue& /*value*/, ParsedConfiguration& parsed) {
  parsed.configuration.watchdog_is_chosen = true;
}

bool is_server(const std::string& text) {
  return wire::parse_server_address(text).has_value();
}

void check_network(const YamlValue& value, ParsedConfiguration& parsed) {
  const wire::NetworkSettings& network = parsed.configuration.network;
  if (!network.peers.empty() && !network.discovery_servers.empty()) {
    value.refuse("peers and discovery servers cannot be used together: name only one kind");
  }
}

/// Keys of an axis that are read last, in this order: `mechanics` depends on the model, and the
/// others may use the unit that follows from it.
constexpr std::array<std::string_view, 3> kLastKeys{"mechanics", "initial_position", "parameters"};

bool is_read_last(std::string_view key) {
  return std::ranges::find(kLastKeys, key) != kLastKeys.end();
}

/// Values with a unit are not checked if the unit is wrong, to avoid misleading errors. With
/// mechanics the unit also depends on the model.
/// @param wrong keys of the axis whose values were refused
bool is_unit_known(const std::set<std::string>& wrong, bool has_mechanics) {
  return !wrong.contains("unit") && !wrong.contains("mechanics") &&
         !(has_mechanics && wrong.contains("model"));
}

/// Refuses a unit that differs from the one that follows from `mechanics`.
void check_unit(const YamlValue& place, const Unit& written, const Unit& unit) {
  if (written == unit) return;
  place.refuse("contradicts mechanics, from which {kind: " + std::string(to_string(unit.kind)) +
               ", name: " + unit.name +
               (unit.kind == UnitKind::linear ? ", per_unit: " : ", per_revolution: ") +
               to_text(unit.size) + "} follows; remove it");
}

void name_axis(const YamlValue& value, NamedAxis& axis) {
  if (axis.number == 0)
    value.refuse("the axis has no number; add number: 1 to " + std::to_string(kAxisNumbers - 1));
  if (axis.name.empty()) axis.name = "axis" + std::to_string(axis.number);
}

NamedAxis read_axis(const YamlValue& value) {
  NamedAxis axis;
  AxisEntries entries;
  settings::Mistakes mistakes;
  std::set<std::string> wrong;
  const auto read = [&](const std::string& key, const YamlValue& entry) {
    const bool is_good = mistakes.collect([&] {
      settings::read_key(axis_rows(), key, entry, axis);
    });
    if (!is_good) wrong.insert(key);
  };
  mistakes.collect([&] {
    value.for_each_entry(settings::keys_of(axis_rows()),
                         [&](const std::string& key, const YamlValue& entry) {
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

void read_axes(const YamlValue& value, ParsedConfiguration& configuration) {
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
  configuration.axes = std::move(parsed);
}

void write_axes(YAML::Emitter& out, const Rule& /*rule*/, const ParsedConfiguration& parsed) {
  out << YAML::BeginSeq;
  for (const NamedAxis& axis : parsed.configuration.axes) write_section(out, axis_rows(), axis);
  out << YAML::EndSeq;
}

void describe_axis_keys(const std::string& path, std::vector<settings::ConfigurationKey>& keys) {
  describe_section(path + "[].", axis_rows(), keys);
}

constexpr auto kBenchRows = std::to_array<Row<Configuration>>({
    key<&Configuration::bench>("number", IntegerLimits{1, wire::kHighestBench, ""},
                               "{}, unique in its DDS domain."),
    key<&Configuration::name>("name", Any{}, "1 to 64 bytes of UTF-8 without control characters.",
                              {.then = check_bench_name}),
});

constexpr auto kClockRows = std::to_array<Row<Configuration>>({
    key<&Configuration::clock>(
        "mode", kOneOf<ClockMode::realtime, ClockMode::lockstep, ClockMode::freerun>,
        "realtime: by the wall clock; lockstep: by steps of clients; freerun: as fast as "
        "possible."),
    key<&Configuration::period>(
        "period_us", IntegerLimits{kShortestPeriod.count(), kLongestPeriod.count(), "us"},
        "Length of a tick, {} us."),
    key<&Configuration::rate>(
        "rate", Any{},
        "realtime: drive time over wall time, 0 (paused) or 0.1 to 100. Refused with the other "
        "modes.",
        {.then = check_rate, .is_printed = has_rate}),
    key<&Configuration::steppers>("steppers", IntegerLimits{0, kMaxSteppers, ""},
                                  "lockstep: time stands still until this many programs have "
                                  "joined the clock, {}; 0: no wait."),
    key<&Configuration::clock_step>(
        "clock_step", kOneOf<WallStepPolicy::steer, WallStepPolicy::jump>,
        "realtime at rate 1, after a change of the wall clock: steer (slowly, by 500 ppm) or "
        "jump (immediately, forward only)."),
    key<&Configuration::threads>(
        "threads", IntegerLimits{1, kMaxThreads, ""},
        "Threads that step the axes, {}. The result is the same for any number."),
    key<&Configuration::realtime_priority>(
        "realtime_priority", IntegerLimits{0, kHighestPriority, ""},
        "SCHED_FIFO priority of the tick thread, if permitted, {}; 0: none."),
});

constexpr auto kStatusRows = std::to_array<Row<Configuration>>({
    key<&Configuration::status_every>("every_ticks", IntegerLimits{1, kMaxStatusEvery, "ticks"},
                                      "One status frame every n ticks, {}."),
});

constexpr auto kWatchdogRows = std::to_array<Row<Configuration>>({
    key<&Configuration::watchdog>(
        "timeout_ms",
        IntegerOrNone{{kShortestWatchdog.count(), kLongestWatchdog.count(), "ms, or off"}, "off"},
        "Time within which the owner of an axis must send something, {} ms of drive time (of wall "
        "time at rates above 1), or off. Off in freerun unless the key is set."),
});

constexpr auto kWireRows = std::to_array<Row<Configuration>>({
    key<&Configuration::wire_form>(
        "form", kOneOf<WireForm::process, WireForm::thread>,
        "Where DDS runs: in a process, which the service restarts when it fails, or in a "
        "thread of the service. Default: process in realtime, with network.security and with "
        "an interface other than loopback; thread otherwise and with shared memory."),
    key<&Configuration::wire_memory_limit_mib>(
        "memory_limit_mib", IntegerLimits{64, 65'536, "MiB"},
        "Memory limit of the network process, {} MiB; above it, the process is restarted."),
});

constexpr auto kBlackBoxRows = std::to_array<Row<Configuration>>({
    key<&Configuration::black_box_memory_mib>(
        "memory_mib", IntegerLimits{0, 4'096, "MiB"},
        "Memory for the black box (the last minutes of the bench), {} MiB, see `vdrive faults`; 0: "
        "off. Allocated as needed."),
});

constexpr TextRule kAddress{.fits = wire::is_address,
                            .refusal = "must be an IPv4 address, such as 10.0.0.1"};

constexpr auto kMetricsRows = std::to_array<Row<Configuration>>({
    key<&Configuration::metrics_address>("address", kAddress,
                                         "IPv4 address of this machine; 0.0.0.0: all of them, for "
                                         "a cluster. There is no access control.",
                                         {.is_printed = has_metrics}),
    key<&Configuration::metrics_port>(
        "port", IntegerLimits{0, kHighestPort, ", 0 = any free one"},
        "Prometheus text on this port of the address, {}; 0: any free one. Without the key "
        "there are no metrics."),
});

constexpr TextRule kInterface{
    .fits = wire::is_interface,
    .refusal = "must be an IPv4 address or an interface, such as 10.0.0.1 or eth0"};
constexpr TextRule kHost{.fits = wire::is_host,
                         .refusal = "must be an IPv4 address or a host name, such as 10.0.0.1"};
constexpr TextRule kServer{.fits = is_server,
                           .refusal = "must be a host and a port, such as 10.0.0.9:11811"};
constexpr TextRule kCredentials{
    .if_empty = "must name a directory; leave out this key for an open bench", .is_quoted = true};

constexpr auto kNetworkRows = std::to_array<Row<wire::NetworkSettings>>({
    key<&wire::NetworkSettings::domain>("domain", IntegerLimits{0, wire::kHighestDomain, ""},
                                        "DDS domain, {}."),
    key<&wire::NetworkSettings::interfaces>(
        "interfaces", kInterface,
        "List of this machine's IPv4 addresses or interfaces (eth0) in the networks to serve; "
        "empty: this machine only."),
    key<&wire::NetworkSettings::peers>(
        "peers", kHost,
        "List of hosts, by IPv4 address or name, to contact in addition to multicast."),
    key<&wire::NetworkSettings::discovery_servers>(
        "discovery_server", kServer,
        "List of servers, such as 10.0.0.9:11811, used instead of multicast and peers."),
    key<&wire::NetworkSettings::shared_memory>(
        "shared_memory", Any{},
        "true: DDS also uses shared memory, and runs in threads of the service."),
    key<&wire::NetworkSettings::security>(
        "security", kCredentials,
        "Directory with the credentials for the closed mode. Without this key the bench is open."),
});

constexpr auto kBench = &ParsedConfiguration::configuration;

constexpr auto kRootRows = std::to_array<Row<ParsedConfiguration>>({
    section<kBenchRows, kBench>("bench"),
    section<kClockRows, kBench>("clock", {.then = refuse_keys_of_other_modes}),
    section<kStatusRows, kBench>("status"),
    section<kWatchdogRows, kBench>("watchdog", {.then = choose_watchdog}),
    section<kWireRows, kBench>("wire"),
    section<kBlackBoxRows, kBench>("black_box"),
    section<kMetricsRows, kBench>("metrics"),
    section<kNetworkRows, kBench, &Configuration::network>("network", {.then = check_network}),
    {.key = "axes", .then = read_axes, .write = write_axes, .describe = describe_axis_keys},
});

}  // namespace

void check_name(const YamlValue& value, const std::string& name) {
  if (name.empty() || name.size() > kMaxNameLength) {
    value.refuse("a name must have 1 to " + std::to_string(kMaxNameLength) + " bytes");
  }
  if (has_control_characters(name)) value.refuse("a name must not have control characters");
}

std::span<const Row<ParsedConfiguration>> configuration_rows() noexcept {
  return kRootRows;
}

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#include "bridge/settings.hpp"

#include "bridge/node_ids.hpp"
#include "settings/configuration_error.hpp"
#include "settings/rows.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/bench_number.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <utility>
#include <variant>

namespace vdrive::canopen {
namespace {

using vdrive::settings::ConfigurationError;
using vdrive::settings::IntegerLimits;
using vdrive::settings::key;
using vdrive::settings::kOneOf;
using vdrive::settings::Row;
using vdrive::settings::TextRule;
using vdrive::settings::YamlValue;

/// The default port of socketcand clients.
const TcpAddress kUsualSocketcand{.host = "127.0.0.1", .port = 29'536};

constexpr std::size_t kLongestNameOfBus = 16;  // a Linux interface name has 15 at most

bool is_bus_name(const std::string& name) {
  constexpr std::string_view kMay =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.";
  return !name.empty() && name.size() <= kLongestNameOfBus && name.front() != '.' &&
         name.find_first_not_of(kMay) == std::string_view::npos;
}

template <auto kMember>
void read_addresses(const YamlValue& list, BusSetting& bus) {
  list.for_each_element([&](const YamlValue& element) {
    const auto address = parse_tcp_address(element.text());
    if (!address) element.refuse("must be an address and a port, such as 127.0.0.1:29536");
    (bus.*kMember).push_back(*address);
  });
}

constexpr IntegerLimits kNodeOffsets{kLowestNodeOffset, kHighestNodeOffset, ""};

constexpr auto kBenchRows = std::to_array<Row<BenchSetting>>({
    key<&BenchSetting::number>("bench", IntegerLimits{1, wire::kHighestBench, ""}, {},
                               {.needed = "needs the key bench, the number of the bench"}),
    key<&BenchSetting::node_offset>("node_offset", kNodeOffsets),
    key<&BenchSetting::axes>("axes", IntegerLimits{1, kMostNodes, ""}),
    key<&BenchSetting::preset>("preset"),
    key<&BenchSetting::configuration>("config"),
});

void read_benches(const YamlValue& list, BusSetting& bus) {
  list.for_each_element([&](const YamlValue& element) {
    BenchSetting bench;
    read_section(element, kBenchRows, bench);
    if ((bench.axes || !bench.preset.empty()) && !bench.configuration.empty()) {
      element.refuse((bench.axes ? std::string("axes") : std::string("preset")) +
                     " and config are both given: give only one");
    }
    bus.benches.push_back(bench);
  });
}

void read_faults(const YamlValue& list, BusSetting& bus) {
  std::vector<BusFault>& faults = bus.faults;
  list.for_each_element([&](const YamlValue& element) {
    if (faults.size() >= BusFaults::kMostFaults) {
      element.refuse("a bus has at most " + std::to_string(BusFaults::kMostFaults) + " faults");
    }
    const auto fault = parse_fault_of_node(element.text());
    if (const auto* const refusal = std::get_if<std::string>(&fault)) element.refuse(*refusal);
    faults.push_back(std::get<BusFault>(fault));
  });
}

constexpr TextRule kBusName{.fits = is_bus_name,
                            .refusal = "must be 1 to 16 letters, digits, '-', '_' or '.'"};
constexpr TextRule kInterface{.if_empty = "must be the name of an interface, such as can0"};

constexpr auto kBusRows = std::to_array<Row<BusSetting>>({
    key<&BusSetting::name>("name", kBusName),
    {.key = "socketcand", .then = read_addresses<&BusSetting::socketcand>},
    {.key = "gateways", .then = read_addresses<&BusSetting::gateways>},
    key<&BusSetting::interfaces>("interfaces", kInterface),
    key<&BusSetting::node_offset>("node_offset", kNodeOffsets),
    key<&BusSetting::log>("log", TextRule{.if_empty = "must be the name of a file"}),
    {.key = "disturb", .then = read_faults},
    {.key = "benches", .then = read_benches},
});

void read_buses(const YamlValue& list, Settings& settings) {
  std::vector<BusSetting>& buses = settings.buses;
  buses.clear();  // the key replaces the list, it does not add to it
  list.for_each_element([&](const YamlValue& element) {
    BusSetting bus{.name = "can" + std::to_string(buses.size())};
    read_section(element, kBusRows, bus);
    buses.push_back(bus);
    if (std::ranges::count(buses, bus.name, &BusSetting::name) > 1) {
      element.refuse("another bus has the name " + in_quotes(bus.name));
    }
  });
}

constexpr auto kRows = std::to_array<Row<Settings>>({
    key<&Settings::is_private>("private"),
    key<&Settings::clock>("clock", kOneOf<ClockMode::realtime, ClockMode::lockstep>),
    key<&Settings::sync_steps>(
        "sync_steps_us", IntegerLimits{kShortestSyncStep.count(), kLongestSyncStep.count(), "us"}),
    key<&Settings::state>("state", TextRule{.if_empty = "must be the name of a directory"}),
    key<&Settings::journal>("journal", TextRule{.if_empty = "must be the name of a file"}),
    {.key = "buses", .then = read_buses},
});

// ---- consistency of several settings ---------------------------------------------------------

bool has_port(const BusSetting& bus) {
  return !bus.socketcand.empty() || !bus.gateways.empty() || !bus.interfaces.empty();
}

/// @param taken the servers of all buses so far
void take_servers(const std::vector<TcpAddress>& addresses, std::set<std::string>& taken) {
  for (const TcpAddress& address : addresses) {
    const std::string text = address_text(address);
    if (address.port != 0 && !taken.insert(text).second) {
      throw ConfigurationError("two servers listen on " + text);
    }
  }
}

void check_ports(const std::vector<BusSetting>& buses) {
  std::set<std::string> taken;
  for (const BusSetting& bus : buses) {
    if (!has_port(bus)) {
      throw ConfigurationError("bus " + bus.name +
                               ": no client can reach it; add socketcand, gateways or interfaces");
    }
    take_servers(bus.socketcand, taken);
    take_servers(bus.gateways, taken);
    for (const std::string& interface : bus.interfaces) {
      if (!taken.insert(interface).second) {
        throw ConfigurationError("the interface " + in_quotes(interface) + " is given twice");
      }
    }
    if (!bus.log.empty() && !taken.insert(bus.log.string()).second) {
      throw ConfigurationError("the log " + in_quotes(bus.log.string()) +
                               " is given twice: give each bus its own");
    }
  }
}

/// An axis must not be two nodes: its owner and its heartbeat would be ambiguous.
void check_benches(const Settings& settings) {
  std::set<std::uint32_t> taken;
  for (const BusSetting& bus : settings.buses) {
    if (bus.benches.empty() && settings.buses.size() > 1) {
      throw ConfigurationError("bus " + bus.name +
                               ": with several buses, each needs a list of benches");
    }
    for (const BenchSetting& bench : bus.benches) {
      const std::string name = "bench " + std::to_string(bench.number);
      if (!taken.insert(bench.number).second) throw ConfigurationError(name + " is given twice");
      const bool is_described = bench.axes || !bench.preset.empty() || !bench.configuration.empty();
      if (is_described && !settings.is_private) {
        throw ConfigurationError(
            name + ": axes, preset and config apply only to a private bench; add --private");
      }
    }
  }
}

void check_fault_nodes(const BusSetting& bus, const NodeIds& ids) {
  for (const BusFault& fault : bus.faults) {
    if (fault.node == 0 || ids.contains(fault.node)) continue;
    throw ConfigurationError("bus " + bus.name + ": a fault names node " +
                             std::to_string(fault.node) + ", but the bus has " + ids.text());
  }
}

/// The axes of a private bench are numbered from 1. A bench with a configuration is checked at its
/// start.
void check_node_ids(const Settings& settings) {
  for (const BusSetting& bus : settings.buses) {
    NodeIds ids;
    for (const BenchSetting& bench : bus.benches) {
      std::vector<client::AxisInfo> axes(bench.axes.value_or(0));
      for (std::size_t place = 0; place < axes.size(); ++place) {
        axes[place].id = {.bench = bench.number, .axis = static_cast<std::uint16_t>(place + 1)};
      }
      if (const auto refusal = ids.add(axes, bench.node_offset)) {
        throw ConfigurationError("bench " + std::to_string(bench.number) + ": " + *refusal);
      }
    }
    const bool are_known = std::ranges::all_of(bus.benches, [](const BenchSetting& bench) {
      return bench.axes.has_value();
    });
    if (are_known) check_fault_nodes(bus, ids);
  }
}

void check_journal(const Settings& settings) {
  if (settings.journal.empty()) return;
  if (!settings.is_private) {
    throw ConfigurationError("--journal applies only to a private bench: add --private");
  }
  if (settings.buses.size() > 1 || settings.buses.front().benches.size() > 1) {
    throw ConfigurationError("--journal records one bench, but several are configured");
  }
}

bool names_a_network(const client::SessionOptions& session) {
  return session.domain || !session.interfaces.empty() || !session.peers.empty() ||
         !session.discovery_servers.empty() || !session.security.empty();
}

void check_clock(const Settings& settings) {
  if (settings.is_private && names_a_network(settings.session)) {
    throw ConfigurationError(
        "--private runs the benches in this process: leave out the network options");
  }
  if (!settings.is_private && settings.clock) {
    throw ConfigurationError(
        "--clock applies only to a private bench, since a bench on the network has its own clock: "
        "add --private");
  }
  if (!settings.is_private) return;
  if (settings.clock == ClockMode::lockstep && !settings.sync_steps) {
    throw ConfigurationError(
        "--clock lockstep needs --sync-steps: nothing else advances the time of a private bench");
  }
  if (settings.clock == ClockMode::realtime && settings.sync_steps) {
    throw ConfigurationError(
        "--sync-steps needs --clock lockstep: a realtime clock is not stepped");
  }
}

void complete_private_benches(BusSetting& bus) {
  if (bus.benches.empty()) bus.benches.push_back({.number = 1, .node_offset = bus.node_offset});
  for (BenchSetting& bench : bus.benches) {
    if (bench.configuration.empty() && !bench.axes) bench.axes = 1;
  }
}

}  // namespace

void read_settings(const std::string& text, const std::string& file, Settings& settings) {
  const YAML::Node document = vdrive::settings::read_yaml(text, file);
  if (document.IsNull()) return;
  read_section(YamlValue(document, file, ""), kRows, settings);
}

void complete_settings(Settings& settings) {
  if (settings.buses.empty()) settings.buses.emplace_back();
  for (BusSetting& bus : settings.buses) {
    if (settings.is_private) complete_private_benches(bus);
    if (settings.buses.size() == 1 && !has_port(bus)) bus.socketcand.push_back(kUsualSocketcand);
  }
  check_ports(settings.buses);
  check_benches(settings);
  check_clock(settings);
  check_journal(settings);
  if (settings.is_private) check_node_ids(settings);
  if (settings.is_private && !settings.clock) {
    settings.clock = settings.sync_steps ? ClockMode::lockstep : ClockMode::realtime;
  }
}

}  // namespace vdrive::canopen

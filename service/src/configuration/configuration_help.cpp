// SPDX-License-Identifier: Apache-2.0
#include "configuration/configuration_help.hpp"

#include "configuration/configuration.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/plant/model_parameters.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>

namespace vdrive::service {
namespace {

constexpr std::array kKeys{
    ConfigurationKey{"bench.number", "1 to 65535, unique in its DDS domain."},
    ConfigurationKey{"bench.name", "1 to 64 bytes of UTF-8 without control characters."},
    ConfigurationKey{"clock.mode",
                     "realtime: by the wall clock; lockstep: by steps of clients; freerun: as fast "
                     "as possible."},
    ConfigurationKey{"clock.period_us", "Length of a tick, 125 to 10000 us."},
    ConfigurationKey{"clock.rate",
                     "realtime: drive time over wall time, 0 (paused) or 0.1 to 100. Refused with "
                     "freerun."},
    ConfigurationKey{"clock.clock_step",
                     "realtime at rate 1, after a change of the wall clock: steer (slowly, by 500 "
                     "ppm) or jump (at once, forward only)."},
    ConfigurationKey{"clock.threads",
                     "Threads that step the axes, 1 to 64. The result is the same for any number."},
    ConfigurationKey{"clock.realtime_priority",
                     "SCHED_FIFO of the thread of the ticks where permitted, 0 to 99; 0: none."},
    ConfigurationKey{"status.every_ticks", "One status frame each n ticks, 1 to 10000."},
    ConfigurationKey{"watchdog.timeout_ms",
                     "The owner of an axis must send at least this often: 5 to 10000 ms of drive "
                     "time (at a rate above 1 of wall time), or off. Off in freerun unless the key "
                     "is set."},
    ConfigurationKey{"wire.form",
                     "Where DDS runs: in a process, which the service restarts when it fails, or "
                     "in a thread of the service. Default: process in realtime, with "
                     "network.security and with an interface other than loopback; thread otherwise "
                     "and with shared memory."},
    ConfigurationKey{"wire.memory_limit_mib",
                     "Of the network process, 64 to 65536 MiB: one that uses more is restarted."},
    ConfigurationKey{"metrics.port",
                     "Prometheus text on this port of 127.0.0.1, 0 to 65535; 0: any free one. "
                     "Without the key there are no metrics."},
    ConfigurationKey{"network.domain", "DDS domain, 0 to 232."},
    ConfigurationKey{"network.interfaces",
                     "List of IPv4 addresses of this machine in the networks to serve; empty: this "
                     "machine only."},
    ConfigurationKey{"network.peers",
                     "List of IPv4 addresses of hosts that are searched in addition to multicast."},
    ConfigurationKey{"network.discovery_server",
                     "List of servers, such as 10.0.0.9:11811, used instead of multicast and "
                     "peers."},
    ConfigurationKey{"network.shared_memory",
                     "true: DDS uses shared memory, too, and runs in threads of the service."},
    ConfigurationKey{"network.security",
                     "Directory of the closed mode's material. Without the key the bench is open."},
    ConfigurationKey{"axes[].number",
                     "1 to 65535, unique on the bench. Default: none, each axis needs it."},
    ConfigurationKey{"axes[].name",
                     "Unique, no blanks, no digit first. Default: axis and its number."},
    ConfigurationKey{
        "axes[].unit.kind",
        "What the user units of the axis are: rotary (parts of a revolution) or linear "
        "(parts of a length). Programs convert; the drive does not use it."},
    ConfigurationKey{
        "axes[].unit.name",
        "In which positions are shown. rotary: deg, rad or rev; linear: letters, such "
        "as mm, at most 16 bytes; the key is needed. m, cm, mm and um follow from each "
        "other."},
    ConfigurationKey{"axes[].unit.per_revolution",
                     "rotary: user units in a revolution of the load, 1e-06 to 1e+09."},
    ConfigurationKey{"axes[].unit.per_unit",
                     "linear: user units in one unit, 1e-06 to 1e+09. Default: none, a linear axis "
                     "needs it."},
    ConfigurationKey{"axes[].initial_position", "At the first power-up, in user units."},
    ConfigurationKey{"axes[].settings.acknowledge_while_halted",
                     "false: no set-point is taken while bit 8 of the controlword is 1."},
    ConfigurationKey{"axes[].settings.enable_from_switch_on_disabled",
                     "true: the controlword 000Fh in Switch on disabled enables."},
    ConfigurationKey{"axes[].settings.following_error_is_fault",
                     "false: a following error shows in bit 13 of the statusword only."},
    ConfigurationKey{"axes[].settings.limits_need_homing",
                     "true: 607Dh is in force only once the axis is homed."},
    ConfigurationKey{"axes[].settings.quick_stop_dwell_ms",
                     "Least time in Quick stop active, 0 to 65535 ms."},
    ConfigurationKey{"axes[].model.coupling",
                     "rigid: one inertia; two_inertia: motor and load on an elastic shaft."},
    ConfigurationKey{"axes[].model.feedback",
                     "The position loop uses the encoder of the motor (single_encoder) or of the "
                     "load (dual_encoder)."},
    ConfigurationKey{"axes[].parameters",
                     "Map of objects to the values that they have from power-up on, by "
                     "variable_name, name in CiA 402 or address, such as profile_velocity: 68267 "
                     "and \"0x607D:1\": "
                     "-100000. The gear is load turns over motor turns: gear_ratio_numerator: 1 "
                     "with gear_ratio_denominator: 10 is a gear that reduces ten to one."},
};

/// @return what the configuration that --print-config prints has at `path`; nothing where it has no
///         such key.
std::string default_of(const YAML::Node& printed, std::string_view path) {
  YAML::Node node = YAML::Clone(printed);
  while (!path.empty()) {
    const std::string_view key = path.substr(0, path.find('.'));
    path.remove_prefix(std::min(path.size(), key.size() + 1));
    const bool is_list = key.ends_with("[]");
    node.reset(node[std::string(key.substr(0, key.size() - (is_list ? 2 : 0)))]);
    if (is_list && node) node.reset(node[0]);
    if (!node) return {};
  }
  return node.IsScalar() ? node.Scalar() : std::string();
}

void add(std::string& help, std::string_view key, const std::string& text) {
  help.append(key).append("\n    ").append(text).append("\n");
}

}  // namespace

std::span<const ConfigurationKey> configuration_keys() noexcept {
  return kKeys;
}

std::string configuration_help() {
  const YAML::Node printed = YAML::Load(to_yaml(demo_configuration()));
  std::string help;
  for (const ConfigurationKey& key : kKeys) {
    const bool states_its_default = key.what.find("Default:") != std::string_view::npos;
    const std::string value = states_its_default ? "" : default_of(printed, key.path);
    add(help, key.path, std::string(key.what) + (value.empty() ? "" : " Default: " + value + "."));
    if (key.path != "axes[].model.feedback") continue;
    for (const ModelParameter& parameter : kModelParameters) {
      add(help, "axes[].model." + std::string(parameter.name),
          std::string(parameter.what) + ", " + to_text(parameter.lowest) +
              (parameter.from_zero_if_rigid ? " (rigid: 0)" : "") + " to " +
              to_text(parameter.highest) + " " + std::string(parameter.unit) +
              ". Default: " + to_text(AxisModel{}.*parameter.member) + ".");
    }
  }
  return help;
}

}  // namespace vdrive::service

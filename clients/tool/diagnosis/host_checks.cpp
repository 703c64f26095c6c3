// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/checks.hpp"
#include "gateway_port.hpp"
#include "vdrive/wire/address.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/ports.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>

namespace vdrive::tool {
namespace {

constexpr std::uint64_t kFewFiles = 256;

Finding check_domain(const HostReadings& readings, const GlobalOptions& options) {
  const std::uint32_t first = wire::group_port(options.domain);
  Finding finding{.subject = "domain",
                  .text = "domain " + std::to_string(options.domain) + ", UDP ports from " +
                          std::to_string(first),
                  .advice = ""};
  if (readings.first_ephemeral_port &&
      first + wire::kPortsOfDomain > *readings.first_ephemeral_port) {
    finding.severity = Severity::hint;
    finding.advice =
        "the kernel gives the UDP ports from " + std::to_string(*readings.first_ephemeral_port) +
        " upwards to any program, so another program may hold a port of this domain: use a "
        "domain below " +
        std::to_string((*readings.first_ephemeral_port - wire::kFirstPort) / wire::kPortsOfDomain);
  }
  return finding;
}

std::string addresses_of(const HostReadings& readings) {
  return readings.interfaces.empty() ? "none" : to_text(readings.interfaces);
}

std::vector<Finding> check_interfaces(const HostReadings& readings, const GlobalOptions& options) {
  if (options.interfaces.empty()) {
    return {
        {.subject = "interfaces",
         .text = "loopback only: benches on this machine; it also has " + addresses_of(readings),
         .advice = ""}};
  }
  std::vector<Finding> findings;
  for (const std::string& interface : options.interfaces) {
    Finding& finding =
        findings.emplace_back(Finding{.subject = "interfaces", .text = interface, .advice = ""});
    const auto own = std::ranges::find_if(readings.interfaces, [&](const wire::OwnInterface& one) {
      return one.address == interface || one.name == interface;
    });
    if (own == readings.interfaces.end()) {
      finding.severity = Severity::problem;
      finding.text += " is not an address or interface of this machine";
      finding.advice = "name one of " + addresses_of(readings);
      continue;
    }
    const std::string other = own->name == interface ? own->address : own->name;
    finding.text += (own->name == interface ? " has " : " is on ") + other;
    if (own->is_up) {
      finding.text += ", which is up";
    } else {
      finding.severity = Severity::problem;
      finding.text += ", which is down";
      finding.advice = "ip link set " + own->name + " up";
    }
  }
  return findings;
}

std::vector<Finding> check_multicast(const HostReadings& readings, const GlobalOptions& options) {
  const bool is_needed = options.peers.empty() && options.discovery_servers.empty();
  std::vector<Finding> findings;
  for (const MulticastReading& reading : readings.multicast) {
    Finding finding{
        .subject = "multicast",
        .text = reading.address + (reading.is_received
                                       ? " receives its own multicast to the discovery group"
                                       : " does not receive its own multicast"),
        .advice = ""};
    if (!reading.is_received) {
      finding.severity = is_needed ? Severity::problem : Severity::hint;
      finding.advice = is_needed ? "allow UDP to " + std::string(wire::kDiscoveryGroup) +
                                       " in the firewall, or name the other hosts with --peer or "
                                       "--discovery-server"
                                 : "not needed: peers or a discovery server are named";
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

/// Versions of the library with published faults that a datagram can trigger. docs/SECURITY.md
/// describes the faults and the countermeasures.
constexpr std::array<std::string_view, 2> kFaultyVersions{"2.9.1", "3.1.2"};

Finding check_library(const HostReadings& readings, const GlobalOptions& options) {
  Finding finding{.subject = "library", .text = readings.library, .advice = ""};
  const bool is_faulty = std::ranges::any_of(kFaultyVersions, [&readings](std::string_view one) {
    return readings.library.ends_with(one);
  });
  if (!is_faulty) return finding;
  finding.text += ", which has published faults that a datagram triggers";
  const auto open = std::ranges::find_if_not(options.interfaces, wire::is_loopback);
  if (open == options.interfaces.end()) {
    finding.text += "; only this machine can send one";
  } else {
    finding.severity = Severity::hint;
    finding.advice = "let only hosts that you trust reach " + *open +
                     ": docs/SECURITY.md lists the faults, and which of them vdrive blocks";
  }
  return finding;
}

Finding check_clock(const HostReadings& readings) {
  Finding finding{.subject = "clock", .text = "", .advice = ""};
  if (!readings.is_clock_synchronised) {
    finding.text = "cannot read whether it is synchronised";
  } else if (*readings.is_clock_synchronised) {
    finding.text = "synchronised";
  } else {
    finding.severity = Severity::hint;
    finding.text = "not synchronised";
    finding.advice =
        "run chrony or systemd-timesyncd: benches in real time on several hosts count "
        "the same ticks only with synchronised clocks";
  }
  if (!readings.clock_source.empty()) finding.text += ", source " + readings.clock_source;
  if (readings.clock_source == "acpi_pm" || readings.clock_source == "hpet") {
    finding.severity = Severity::hint;
    finding.advice += (finding.advice.empty() ? "" : "; ") +
                      std::string("reading this source is slow: use tsc or kvm-clock");
  }
  return finding;
}

std::vector<Finding> check_limits(const HostReadings& readings) {
  std::vector<Finding> findings;
  Finding& files =
      findings.emplace_back(Finding{.subject = "limits",
                                    .text = std::to_string(readings.open_files) + " open files",
                                    .advice = ""});
  if (readings.open_files < kFewFiles) {
    files.severity = Severity::hint;
    files.advice = "ulimit -n 1024: each participant needs about 30";
  }
  if (readings.largest_receive_buffer) {
    Finding& buffer = findings.emplace_back(Finding{
        .subject = "limits",
        .text =
            "receive buffers up to " + std::to_string(*readings.largest_receive_buffer) + " bytes",
        .advice = ""});
    if (*readings.largest_receive_buffer < wire::kReceiveBufferOfClient) {
      buffer.severity = Severity::hint;
      buffer.advice =
          "sysctl -w net.core.rmem_max=" + std::to_string(wire::kReceiveBufferOfClient) +
          " before you watch thousands of axes each millisecond: bursts are lost "
          "otherwise";
    }
  }
  return findings;
}

Finding check_priority(const HostReadings& readings) {
  Finding finding{.subject = "real time",
                  .text = "SCHED_FIFO is permitted, " + std::to_string(readings.cores) + " cores",
                  .advice = ""};
  if (!readings.may_run_realtime) {
    finding.severity = Severity::hint;
    finding.text = "SCHED_FIFO is not permitted, " + std::to_string(readings.cores) + " cores";
    finding.advice =
        "clock.realtime_priority has no effect without it: give the service "
        "CAP_SYS_NICE or LimitRTPRIO";
  }
  return finding;
}

/// If more processes than this wait for each core, answers take several times as long.
constexpr double kHighLoadOfCore = 2.0;

std::string with_one_digit(double value) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << value;
  return text.str();
}

Finding check_load(const HostReadings& readings) {
  Finding finding{.subject = "load", .text = "", .advice = ""};
  if (!readings.load) {
    finding.text = "cannot read the load of this machine";
    return finding;
  }
  finding.text = with_one_digit(*readings.load) + " in the last minute on " +
                 counted(readings.cores, "core", "cores") + ", a thread that waited ran up to " +
                 std::to_string(readings.longest_delay.count()) + " ms late";
  if (*readings.load > kHighLoadOfCore * readings.cores) {
    finding.severity = Severity::hint;
    finding.advice =
        "the machine is busy: searches take longer, ticks are late and the watchdog may consider "
        "owners lost; end other programs, raise --timeout and watchdog.timeout_ms, or use "
        "lock-step";
  }
  return finding;
}

Finding check_segments(const HostReadings& readings) {
  const auto stale = std::ranges::count(readings.segments, false, &SharedSegment::is_mapped);
  Finding finding{.subject = "shared memory",
                  .text = std::to_string(readings.segments.size()) + " segments of Fast DDS, " +
                          std::to_string(stale) + " that no program uses",
                  .advice = ""};
  if (stale != 0) {
    finding.severity = Severity::hint;
    finding.advice =
        "killed programs left them: 'fastdds shm clean' removes them, as root also "
        "those of other users";
  }
  return finding;
}

Finding check_gateway(const HostReadings& readings) {
  const std::string address = "127.0.0.1:" + std::to_string(bridge::kGatewayPort);
  Finding finding{.subject = "gateway", .text = "", .advice = ""};
  switch (readings.gateway) {
    case GatewayReading::none:
      finding.text = "no vdrive-gateway on " + address;
      break;
    case GatewayReading::gateway:
      finding.text = "vdrive-gateway answers on http://" + address + "/";
      break;
    case GatewayReading::another:
      finding.severity = Severity::hint;
      finding.text = "another program has port " + address;
      finding.advice = "give vdrive-gateway another port with --listen";
      break;
  }
  return finding;
}

void append(std::vector<Finding>& findings, std::vector<Finding> more) {
  std::ranges::move(more, std::back_inserter(findings));
}

}  // namespace

std::vector<Finding> check_host(const HostReadings& readings, const GlobalOptions& options) {
  std::vector<Finding> findings{check_domain(readings, options)};
  append(findings, check_interfaces(readings, options));
  append(findings, check_multicast(readings, options));
  findings.push_back(check_library(readings, options));
  findings.push_back(check_clock(readings));
  append(findings, check_limits(readings));
  findings.push_back(check_priority(readings));
  findings.push_back(check_load(readings));
  findings.push_back(check_segments(readings));
  findings.push_back(check_gateway(readings));
  return findings;
}

}  // namespace vdrive::tool

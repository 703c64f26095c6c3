// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/global_options.hpp"
#include "output/record.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/wire/address.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::tool {

enum class Severity : std::uint8_t {
  good,
  hint,     ///< works, but not optimally, or not for every use
  problem,  ///< benches will not be found, or will not run
};

/// The result of one check.
struct Finding {
  Severity severity = Severity::good;
  std::string subject;                    ///< such as "multicast"
  std::string text;                       ///< what was found
  std::string advice;                     ///< what to do; empty if good
  std::vector<client::Figure> figures{};  ///< of a bench; machine-readable output only
};

/// @return a line of `vdrive doctor`.
[[nodiscard]] Record finding_record(const Finding& finding);

/// Whether multicast works on one of our addresses: a datagram sent from it to the discovery group
/// of DDS reaches a socket that has joined the group on the same address.
struct MulticastReading {
  std::string address;
  bool is_received = false;
};

/// Shared memory of Fast DDS in /dev/shm.
struct SharedSegment {
  std::string name;
  bool is_mapped = false;  ///< mapped by a process that we may inspect
};

/// The program that listens on the port of vdrive-gateway on loopback.
enum class GatewayReading : std::uint8_t { none, gateway, another };

/// The state of the machine, as far as it matters for DDS and ticks. Nothing = cannot be read.
struct HostReadings {
  std::string library;  ///< DDS library with its version
  std::vector<wire::OwnInterface> interfaces;
  std::vector<MulticastReading> multicast;
  std::vector<SharedSegment> segments;
  std::optional<bool> is_clock_synchronised;
  std::string clock_source;
  std::optional<std::uint64_t> largest_receive_buffer;  ///< net.core.rmem_max [bytes]
  std::optional<std::uint64_t> first_ephemeral_port;
  std::uint64_t open_files = 0;  ///< RLIMIT_NOFILE
  unsigned cores = 0;
  std::optional<double> load;  ///< processes running or waiting for a core, mean of the last minute
  std::chrono::milliseconds longest_delay{};  ///< of a thread after a wait of 1 ms
  bool may_run_realtime = false;              ///< SCHED_FIFO
  GatewayReading gateway = GatewayReading::none;
};

/// Takes the readings. Writes nothing; the multicast probe waits up to 300 ms per address.
/// @param interfaces own addresses or interfaces in the networks to use; none = loopback
[[nodiscard]] HostReadings read_host(const std::vector<std::string>& interfaces);

/// Diagnostics that a vdrive-ros2 in the domain publishes about a bench.
struct RosBench {
  std::string session{};  ///< of the bridge
  std::string bench{};    ///< such as "bench 1"
  std::uint8_t level = 0;
  std::string message{};
  std::string control{};  ///< "this bridge", "no session", or the controlling session
  std::string enable{};   ///< "true" if axes should be enabled
  std::string network{};  ///< "loopback only", or addresses
};

/// The state of ROS 2 on this machine and in this domain.
struct RosReadings {
  std::string domain_id{};        ///< ROS_DOMAIN_ID; empty = not set
  std::string middleware{};       ///< RMW_IMPLEMENTATION
  std::string discovery_range{};  ///< ROS_AUTOMATIC_DISCOVERY_RANGE
  std::vector<RosBench> benches{};
};

/// Takes the readings from the environment, and from /diagnostics in the domain for up to 1.6 s.
/// @throws std::runtime_error when DDS cannot be set up
[[nodiscard]] RosReadings read_ros(const GlobalOptions& options);

/// @param troubles from Session::network_troubles()
[[nodiscard]] std::vector<Finding> check_troubles(std::span<const std::string> troubles);

/// Checks the benches found in the domain.
[[nodiscard]] std::vector<Finding> check_benches(std::span<const client::BenchInfo> benches,
                                                 const GlobalOptions& options);

/// Checks the readings of the machine for use with these options.
[[nodiscard]] std::vector<Finding> check_host(const HostReadings& readings,
                                              const GlobalOptions& options);

/// Checks the readings of ROS 2: its environment here, and vdrive-ros2 in the domain.
[[nodiscard]] std::vector<Finding> check_ros(const RosReadings& readings,
                                             const GlobalOptions& options);

}  // namespace vdrive::tool

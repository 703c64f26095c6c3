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
  hint,     ///< works, but not at its best, or not for every use
  problem,  ///< benches will not be found, or not run
};

/// One thing that was checked.
struct Finding {
  Severity severity = Severity::good;
  std::string subject;                    ///< such as "multicast"
  std::string text;                       ///< what was found
  std::string advice;                     ///< what to do; empty when good
  std::vector<client::Figure> figures{};  ///< of a bench; for programs only
};

/// @return a line of `vdrive doctor`.
[[nodiscard]] Record finding_record(const Finding& finding);

/// Whether a datagram to the discovery group of DDS, sent from an own address, arrives there.
struct MulticastReading {
  std::string address;
  bool is_received = false;
};

/// Shared memory of Fast DDS in /dev/shm.
struct SharedSegment {
  std::string name;
  bool is_mapped = false;  ///< by a process that we may inspect
};

/// Which program has the port of vdrive-gateway on loopback.
enum class GatewayReading : std::uint8_t { none, gateway, another };

/// What the machine shows of itself, as far as it concerns DDS and ticks. Nothing = it cannot be
/// read.
struct HostReadings {
  std::string library;  ///< of DDS, with its version
  std::vector<wire::OwnInterface> interfaces;
  std::vector<MulticastReading> multicast;
  std::vector<SharedSegment> segments;
  std::optional<bool> is_clock_synchronised;
  std::string clock_source;
  std::optional<std::uint64_t> largest_receive_buffer;  ///< net.core.rmem_max [bytes]
  std::optional<std::uint64_t> first_ephemeral_port;
  std::uint64_t open_files = 0;  ///< RLIMIT_NOFILE
  unsigned cores = 0;
  std::optional<double> load;  ///< programs that run or wait for a core, mean of the last minute
  std::chrono::milliseconds longest_delay{};  ///< with which a thread ran after a wait of 1 ms
  bool may_run_realtime = false;              ///< SCHED_FIFO
  GatewayReading gateway = GatewayReading::none;
};

/// Takes the readings. Writes nothing; the multicast probe waits up to 300 ms an address.
/// @param interfaces own addresses or interfaces in the networks that are used; none = loopback
[[nodiscard]] HostReadings read_host(const std::vector<std::string>& interfaces);

/// What a vdrive-ros2 of the domain publishes about one bench.
struct RosBench {
  std::string session{};  ///< of the bridge
  std::string bench{};    ///< such as "bench 1"
  std::uint8_t level = 0;
  std::string message{};
  std::string control{};  ///< "this bridge", "no session", or the session that has it
  std::string enable{};   ///< "true" where axes are to be enabled
  std::string network{};  ///< "loopback only", or addresses
};

/// What this machine and this domain show of ROS 2.
struct RosReadings {
  std::string domain_id{};        ///< ROS_DOMAIN_ID; empty = not set
  std::string middleware{};       ///< RMW_IMPLEMENTATION
  std::string discovery_range{};  ///< ROS_AUTOMATIC_DISCOVERY_RANGE
  std::vector<RosBench> benches{};
};

/// Takes the readings: reads the environment, and /diagnostics in the domain for up to 1.6 s.
/// @throws std::runtime_error when DDS cannot be set up
[[nodiscard]] RosReadings read_ros(const GlobalOptions& options);

/// @param troubles of Session::network_troubles()
[[nodiscard]] std::vector<Finding> check_troubles(std::span<const std::string> troubles);

/// Judges the benches that were found on the domain.
[[nodiscard]] std::vector<Finding> check_benches(std::span<const client::BenchInfo> benches,
                                                 const GlobalOptions& options);

/// Judges what was read of the machine, for a use with these options.
[[nodiscard]] std::vector<Finding> check_host(const HostReadings& readings,
                                              const GlobalOptions& options);

/// Judges what was found of ROS 2: its environment here, and vdrive-ros2 in the domain.
[[nodiscard]] std::vector<Finding> check_ros(const RosReadings& readings,
                                             const GlobalOptions& options);

}  // namespace vdrive::tool

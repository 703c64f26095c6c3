// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// An IPv4 address of this host.
struct NetworkInterface {
  std::string name;
  std::string address;
  bool is_up = false;
};

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
  std::vector<NetworkInterface> interfaces;
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
/// @param addresses own addresses in the networks that are used; none = loopback
[[nodiscard]] HostReadings read_host(const std::vector<std::string>& addresses);

}  // namespace vdrive::tool

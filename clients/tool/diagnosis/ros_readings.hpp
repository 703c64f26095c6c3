// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/global_options.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::tool {

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

}  // namespace vdrive::tool

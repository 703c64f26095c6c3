// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "diagnosis/host_readings.hpp"
#include "diagnosis/ros_readings.hpp"
#include "language/global_options.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/client/outcome.hpp"

#include <cstdint>
#include <functional>
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
  std::string subject;  ///< such as "multicast"
  std::string text;     ///< what was found
  std::string advice;   ///< what to do; empty when good
};

/// Judges what was read of the machine, for a use with these options.
[[nodiscard]] std::vector<Finding> diagnose(const HostReadings& readings,
                                            const GlobalOptions& options);

/// Judges the benches that were found on the domain.
[[nodiscard]] std::vector<Finding> check_benches(std::span<const client::BenchInfo> benches,
                                                 const GlobalOptions& options);

/// Judges what was found of ROS 2: its environment here, and vdrive-ros2 in the domain.
[[nodiscard]] std::vector<Finding> check_ros(const RosReadings& readings,
                                             const GlobalOptions& options);

/// `vdrive doctor`: reads the machine, finds the benches, and shows the findings.
/// @return failed when there is a problem.
/// @param find finds the benches on the domain; what it throws is a problem
client::Outcome run_doctor(const GlobalOptions& options, Terminal& terminal,
                           const std::function<std::vector<client::BenchInfo>()>& find);

}  // namespace vdrive::tool

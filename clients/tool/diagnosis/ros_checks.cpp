// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/checks.hpp"
#include "vdrive/text.hpp"

#include <string>

namespace vdrive::tool {
namespace {

Finding check_ros_bench(const RosBench& bench) {
  Finding finding{.subject = "ROS 2",
                  .text = "vdrive-ros2, session " + bench.session + ", " + bench.network + ": ",
                  .advice = ""};
  const bool is_foreign = bench.control.starts_with("session");
  if (!bench.control.empty()) {
    finding.text += bench.bench + " " + bench.message + ", controlled by " + bench.control;
  } else {
    finding.text +=
        bench.message.starts_with(bench.bench) ? bench.message : bench.bench + " " + bench.message;
  }
  if (bench.enable == "true" && is_foreign) {
    finding.severity = Severity::hint;
    finding.advice =
        "it waits for that session, which may be another vdrive-ros2 with --enable: end one of "
        "them";
  } else if (bench.level != 0) {
    finding.severity = Severity::hint;
    finding.advice = bench.control.empty() && bench.message.find("left out") != std::string::npos
                         ? "give each joint a unique name: --prefix, or joints: in the "
                           "configuration of vdrive-ros2"
                         : "/diagnostics and /rosout name the reason";
  }
  return finding;
}

}  // namespace

std::vector<Finding> check_ros(const RosReadings& readings, const GlobalOptions& options) {
  std::vector<Finding> findings;
  const std::string domain = std::to_string(options.domain);
  for (const RosBench& bench : readings.benches) findings.push_back(check_ros_bench(bench));
  if (findings.empty()) {
    findings.push_back({.subject = "ROS 2",
                        .text = "no vdrive-ros2 publishes /diagnostics on domain " + domain,
                        .advice = ""});
  }
  if (!readings.domain_id.empty() && readings.domain_id != domain) {
    findings.push_back({.severity = Severity::hint,
                        .subject = "ROS 2",
                        .text = "ROS_DOMAIN_ID is " + in_quotes(readings.domain_id) +
                                ": nodes that start here are not on domain " + domain,
                        .advice = "start service and bridge with --domain " + readings.domain_id +
                                  ", or set ROS_DOMAIN_ID to " + domain});
  }
  if (readings.middleware.starts_with("rmw_zenoh")) {
    findings.push_back({.severity = Severity::hint,
                        .subject = "ROS 2",
                        .text = "RMW_IMPLEMENTATION is " + in_quotes(readings.middleware) +
                                ", which is not DDS: nodes that start here find no vdrive-ros2",
                        .advice = "use rmw_fastrtps_cpp or rmw_cyclonedds_cpp"});
  }
  if (readings.discovery_range == "OFF") {
    findings.push_back({.severity = Severity::hint,
                        .subject = "ROS 2",
                        .text = "ROS_AUTOMATIC_DISCOVERY_RANGE is OFF: nodes that start here find "
                                "no other program",
                        .advice = "set it to LOCALHOST or SUBNET"});
  }
  return findings;
}

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/checks.hpp"
#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <map>
#include <mutex>
#include <utility>

namespace vdrive::tool {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds kDiscovery{700};     // if no publisher is found by then, there is none
constexpr milliseconds kDiagnostics{1600};  // a bridge publishes them once a second
constexpr milliseconds kTurn{20};           // polling period: a matched publisher wakes nobody

std::string variable(const char* name) {
  const char* const value = std::getenv(name);  // NOLINT(*-mt-unsafe): nothing sets variables
  return value == nullptr ? "" : value;
}

/// Collects the benches that the bridges of a domain publish, by session and bench.
class DiagnosticsListener {
 public:
  void take(const ros::DiagnosticArray& message) {
    const std::scoped_lock lock(mutex_);
    for (const ros::DiagnosticStatus& status : message.status) add(status);
  }

  [[nodiscard]] std::vector<RosBench> result() {
    const std::scoped_lock lock(mutex_);
    std::vector<RosBench> benches;
    benches.reserve(benches_.size());
    for (const auto& [key, bench] : benches_) benches.push_back(bench);
    return benches;
  }

 private:
  void add(const ros::DiagnosticStatus& status) {
    constexpr std::string_view kPrefix = "vdrive_ros2: ";
    if (!status.name.starts_with(kPrefix)) return;
    RosBench bench{.bench = status.name.substr(kPrefix.size()),
                   .level = std::to_integer<std::uint8_t>(status.level),
                   .message = status.message};
    if (!bench.bench.starts_with("bench ")) return;
    for (const ros::KeyValue& pair : status.values) {
      if (pair.key == "session") bench.session = pair.value;
      if (pair.key == "control") bench.control = pair.value;
      if (pair.key == "enable") bench.enable = pair.value;
      if (pair.key == "network") bench.network = pair.value;
    }
    const auto key = std::pair(bench.session, bench.bench);
    benches_[key] = std::move(bench);
  }

  std::mutex mutex_;
  std::map<std::pair<std::string, std::string>, RosBench> benches_;
};

std::vector<RosBench> read_diagnostics(const GlobalOptions& options) {
  DiagnosticsListener diagnostics;
  const auto participant = wire::make_participant({.domain = options.domain,
                                                   .interfaces = options.interfaces,
                                                   .peers = options.peers,
                                                   .discovery_servers = options.discovery_servers},
                                                  "vdrive doctor");
  const ros::Subscription<ros::DiagnosticArray> subscription(
      *participant, "/diagnostics",
      [&](const ros::DiagnosticArray& message, const wire::WriterId& /*writer*/) {
        diagnostics.take(message);
      });
  const Clock::time_point begin = Clock::now();
  std::mutex mutex;
  std::condition_variable never;
  while (true) {
    const auto passed = Clock::now() - begin;
    if (passed >= kDiagnostics || (passed >= kDiscovery && subscription.matched() == 0)) break;
    std::unique_lock lock(mutex);
    never.wait_for(lock, kTurn);
  }
  return diagnostics.result();
}

}  // namespace

RosReadings read_ros(const GlobalOptions& options) {
  return {.domain_id = variable("ROS_DOMAIN_ID"),
          .middleware = variable("RMW_IMPLEMENTATION"),
          .discovery_range = variable("ROS_AUTOMATIC_DISCOVERY_RANGE"),
          .benches = read_diagnostics(options)};
}

}  // namespace vdrive::tool

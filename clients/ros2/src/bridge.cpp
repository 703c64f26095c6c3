// SPDX-License-Identifier: Apache-2.0
#include "bridge.hpp"

#include "ros_time.hpp"
#include "vdrive/client/event.hpp"
#include "wall_time.hpp"

namespace vdrive::ros2 {
namespace {

using bridge::Severity;

wire::NetworkSettings network_of(const Settings& settings) {
  const client::SessionOptions& session = settings.session;
  return {.domain = session.domain.value_or(0),
          .takes_default_domain = !session.domain,
          .interfaces = session.interfaces,
          .peers = session.peers,
          .discovery_servers = session.discovery_servers};
}

/// @return a function that puts messages and their writers into `inbox`.
auto to_inbox(Inbox& inbox) {
  return [&inbox](const auto& message, const wire::WriterId& writer) {
    inbox.put({.writer = writer, .message = message});
  };
}

}  // namespace

Bridge::Bridge(const Settings& settings)
    : participant_(wire::make_participant(network_of(settings), "vdrive ros2")),
      session_(settings.session),
      rosout_(*participant_, settings.topics.rosout),
      reports_("vdrive-ros2",
               [this](bridge::Severity severity, const std::string& line) {
                 write_log(severity, line);
               }),
      commands_(*participant_, settings.topics.joint_commands, to_inbox(inbox_)),
      trajectories_(*participant_, settings.topics.joint_trajectory, to_inbox(inbox_)),
      enable_(*participant_, settings.topics.enable, to_inbox(inbox_)),
      controller_(session_, settings, reports_, inbox_, board_, commands_, *participant_),
      publisher_(*participant_, settings, board_) {
  session_.on_event([this](const client::Event& event) {
    const auto text = bridge::refusal_report(event, session_.id());
    if (text) reports_.report(Severity::warning, "bench " + std::to_string(event.bench), *text);
  });
}

void Bridge::write_log(bridge::Severity severity, const std::string& line) {
  ros::Log log;
  log.stamp = ros_time(bridge::wall_time());
  log.level = static_cast<std::uint8_t>(severity);
  log.name = "vdrive_ros2";
  log.msg = line;
  (void)rosout_.write(log);
}

void Bridge::report_library(const std::string& words) {
  reports_.report(Severity::warning, "network", dropped_message(words));
}

Bridge::~Bridge() {
  // Otherwise the observer could still use the reports, which are destroyed before the session.
  session_.on_event({});
}

}  // namespace vdrive::ros2

// SPDX-License-Identifier: Apache-2.0
#include "diagnostics.hpp"

#include "control_keeper.hpp"
#include "ros_time.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/number_text.hpp"
#include "wall_time.hpp"

#include <cstddef>
#include <cstdint>
#include <utility>

namespace vdrive::ros2 {
namespace {

using ros::DiagnosticStatus;

// Levels of diagnostic_msgs/DiagnosticStatus.
constexpr std::byte kOk{0};
constexpr std::byte kWarn{1};
constexpr std::byte kError{2};
constexpr std::byte kStale{3};

void add(DiagnosticStatus& status, const char* key, std::string value) {
  ros::KeyValue pair;
  pair.key = key;
  pair.value = std::move(value);
  status.values.push_back(std::move(pair));
}

/// @return the owner of the axes of a bench, as text for the diagnostics.
std::string control_of(const BenchView& view) {
  if (const auto owner = bridge::other_owner(view.state->axes, view.session))
    return owner_text(*owner, view.names.get());
  return bridge::owns_all(view.state->axes, view.session) ? "this bridge" : "no session";
}

DiagnosticStatus bench_status(const BenchView& view, const std::string& network) {
  DiagnosticStatus status;
  status.name = "vdrive_ros2: bench " + std::to_string(view.bench->info().number);
  status.hardware_id = view.bench->info().name;
  status.level = view.state ? kOk : kStale;
  status.message = view.state ? "running" : "sends no status";
  // For a bench that is left out, show the reason.
  if (!view.problem.empty()) {
    status.level = kError;
    status.message = view.problem;
  }
  add(status, "clock", std::string(to_string(view.bench->info().clock_mode)));
  add(status, "enable", view.is_enabled ? "true" : "false");
  add(status, "session", session_text(view.session));
  add(status, "network", network);
  if (view.state) add(status, "control", control_of(view));
  if (view.state) add(status, "tick", std::to_string(view.state->tick));
  return status;
}

std::pair<std::byte, std::string> level_of(const BenchView& view,
                                           const client::AxisSnapshot& axis) {
  const PowerState state = axis.state();
  if (is_fault(state)) {
    return {kError, client::what_it_shows(axis)};
  }
  const bool is_foreign = axis.owner_session != 0 && axis.owner_session != view.session;
  if (view.is_enabled && is_foreign) {
    return {kWarn, "controlled by " + owner_text(axis.owner_session, view.names.get())};
  }
  const bool is_missing = view.is_enabled && state != PowerState::operation_enabled;
  return {is_missing ? kWarn : kOk, std::string(to_string(state))};
}

DiagnosticStatus joint_status(const BenchView& view, std::size_t place) {
  const ServedJoint& joint = view.bench->joints()[place];
  DiagnosticStatus status;
  status.name = "vdrive_ros2: joint " + joint.name;
  status.hardware_id = to_string(joint.axis);
  if (!view.state) {
    status.level = kStale;
    status.message = "its bench sends no status";
    return status;
  }
  const client::AxisSnapshot& axis = view.state->axes[place];
  const auto [level, message] = level_of(view, axis);
  status.level = level;
  status.message = message;
  add(status, "state", std::string(to_string(axis.state())));
  add(status, "mode", std::string(to_string(axis.mode())));
  add(status, "duty", std::string(to_string(view.tasks[place])));
  add(status, "error code", hex(axis.status.error_code, 4));
  add(status, std::string("following error ").append(joint.unit_name()).c_str(),
      text_of(axis.status.load_position_error_value * joint.si_per_user_unit));
  return status;
}

}  // namespace

ros::DiagnosticArray diagnostics_of(const Board::Views& views, const std::string& network) {
  ros::DiagnosticArray array;
  array.header.stamp = ros_time(bridge::wall_time());
  for (const auto& [number, view] : views) {
    array.status.push_back(bench_status(view, network));
    for (std::size_t i = 0; i < view.bench->joints().size(); ++i) {
      array.status.push_back(joint_status(view, i));
    }
  }
  return array;
}

std::string levels_of(const Board::Views& views) {
  std::string levels;
  for (const auto& [number, view] : views) {
    levels += (view.state ? 'a' : 's') + view.problem;
    if (!view.state) continue;
    for (const client::AxisSnapshot& axis : view.state->axes) {
      const auto [level, message] = level_of(view, axis);
      levels += std::to_string(std::to_integer<int>(level)) + message;
    }
  }
  return levels;
}

}  // namespace vdrive::ros2

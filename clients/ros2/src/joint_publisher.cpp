// SPDX-License-Identifier: Apache-2.0
#include "joint_publisher.hpp"

#include "control_keeper.hpp"
#include "joint_values.hpp"
#include "ros_time.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/number_text.hpp"
#include "wall_time.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::ros2 {
namespace {

using ros::DiagnosticStatus;
using std::chrono::milliseconds;

constexpr milliseconds kSilentTurn{10};
constexpr milliseconds kEndOfStep{20};  // no further tick came: the step has ended
constexpr std::chrono::seconds kDiagnostics{1};

enum Level : std::uint8_t { ok = 0, warn = 1, error = 2, stale = 3 };

void add(DiagnosticStatus& status, const char* key, std::string value) {
  ros::KeyValue pair;
  pair.key(key);
  pair.value(std::move(value));
  status.values().push_back(std::move(pair));
}

/// @return who controls the axes of a bench, for a reader of the diagnostics.
std::string control_of(const BenchView& view) {
  if (const auto owner = bridge::other_owner(view.state->axes, view.session))
    return "session " + session_text(*owner);
  return bridge::owns_all(view.state->axes, view.session) ? "this bridge" : "no session";
}

DiagnosticStatus bench_status(const BenchView& view, const std::string& network) {
  DiagnosticStatus status;
  status.name("vdrive_ros2: bench " + std::to_string(view.info->number));
  status.hardware_id(view.info->name);
  status.level(view.state ? ok : stale);
  status.message(view.state ? "running" : "sends no status");
  if (!view.problem.empty()) {
    status.level(error);
    status.message(view.problem);
  }
  add(status, "clock", std::string(to_string(view.info->clock_mode)));
  add(status, "enable", view.is_enabled ? "true" : "false");
  add(status, "session", session_text(view.session));
  add(status, "network", network);
  if (view.state) add(status, "control", control_of(view));
  if (view.state) add(status, "tick", std::to_string(view.state->tick));
  return status;
}

std::pair<Level, std::string> level_of(const BenchView& view, const client::AxisSnapshot& axis) {
  const PowerState state = axis.state();
  if (state == PowerState::fault || state == PowerState::fault_reaction_active) {
    return {error, client::what_it_shows(axis)};
  }
  const bool is_foreign = axis.owner_session != 0 && axis.owner_session != view.session;
  if (view.is_enabled && is_foreign) {
    return {warn, "controlled by session " + session_text(axis.owner_session)};
  }
  const bool is_missing = view.is_enabled && state != PowerState::operation_enabled;
  return {is_missing ? warn : ok, std::string(to_string(state))};
}

DiagnosticStatus joint_status(const BenchView& view, std::size_t place) {
  const Joint& joint = (*view.joints)[place];
  DiagnosticStatus status;
  status.name("vdrive_ros2: joint " + joint.name);
  status.hardware_id(to_string(joint.axis));
  if (!view.state) {
    status.level(stale);
    status.message("its bench sends no status");
    return status;
  }
  const client::AxisSnapshot& axis = view.state->axes[place];
  const auto [level, message] = level_of(view, axis);
  status.level(level);
  status.message(message);
  add(status, "state", std::string(to_string(axis.state())));
  add(status, "mode", std::string(to_string(axis.mode())));
  add(status, "duty", std::string(to_string(view.duties[place])));
  add(status, "error code", hex(axis.status.error_code, 4));
  add(status, std::string("following error ").append(joint.unit_name()).c_str(),
      text_of(axis.status.load_position_error_value * joint.si_per_user_unit));
  return status;
}

/// @return which nodes can find the bridge, for a reader of the diagnostics.
std::string network_text(const client::SessionOptions& options) {
  std::string text;
  for (const std::string& address : options.interfaces) {
    text += (text.empty() ? "" : ", ") + address;
  }
  return text.empty() ? "loopback only" : text;
}

}  // namespace

std::optional<ros::JointState> joint_state_of(const BenchView& view) {
  if (!view.state) return std::nullopt;
  ros::JointState message;
  message.header().stamp(ros_time(stamp_of(*view.info, view.state->tick)));
  const std::size_t count = view.joints->size();
  message.name().reserve(count);
  message.position().reserve(count);
  message.velocity().reserve(count);
  message.effort().reserve(view.limits ? count : 0);
  for (std::size_t i = 0; i < count; ++i) {
    const Joint& joint = (*view.joints)[i];
    bridge::JointScale scale{.si_per_user_unit = joint.si_per_user_unit};
    if (view.limits) scale.effort_per_mille = (*view.limits)[i].effort_per_mille;
    const bridge::JointValues values = bridge::joint_values(view.state->axes[i].status, scale);
    message.name().push_back(joint.name);
    message.position().push_back(values.position);
    message.velocity().push_back(values.velocity);
    if (view.limits) message.effort().push_back(values.effort);
  }
  return message;
}

ros::DiagnosticArray diagnostics_of(const Board::Views& views, const std::string& network) {
  ros::DiagnosticArray array;
  array.header().stamp(ros_time(bridge::wall_time()));
  for (const auto& [number, view] : views) {
    array.status().push_back(bench_status(view, network));
    for (std::size_t i = 0; i < view.joints->size(); ++i) {
      array.status().push_back(joint_status(view, i));
    }
  }
  return array;
}

JointPublisher::JointPublisher(wire::Participant& participant, const Settings& settings,
                               Board& board)
    : rate_(settings.rate),
      network_(network_text(settings.session)),
      board_(board),
      states_(participant, settings.topics.joint_states),
      clock_(participant, settings.topics.clock),
      diagnostics_(participant, settings.topics.diagnostics),
      thread_([this](const std::stop_token& stop) {
        run(stop);
      }) {}

void JointPublisher::run(const std::stop_token& stop) {
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate_));
  while (!stop.stop_requested()) {
    const Clock::time_point now = Clock::now();
    const Board::Views views = board_.views();
    publish(views, now);
    publish_diagnostics(views, now);
    Clock::time_point next = now + std::min<Clock::duration>(period, kSilentTurn);
    for (const auto& [number, published] : published_) {
      if (published.due > now) next = std::min(next, published.due);
    }
    board_.wait_until(next, stop);
  }
}

void JointPublisher::publish(const Board::Views& views, Clock::time_point now) {
  bool has_clock = false;
  for (const auto& [number, view] : views) {
    Published& published = published_[number];
    if (!view.state) continue;
    const bool is_clock = !has_clock && view.info->clock_mode != client::ClockMode::realtime;
    has_clock = has_clock || is_clock;
    if (!is_due(view, published, now)) continue;
    published.tick = view.state->tick;
    if (is_clock) {
      ros::Clock time;
      time.clock(ros_time(stamp_of(*view.info, view.state->tick)));
      (void)clock_.write(time);
    }
    if (const auto message = joint_state_of(view)) (void)states_.write(*message);
  }
}

bool JointPublisher::is_due(const BenchView& view, Published& published,
                            Clock::time_point now) const {
  const std::uint64_t tick = view.state->tick;
  if (published.incarnation != view.info->incarnation) {
    published = {.incarnation = view.info->incarnation};
    published.due = now;
    published.tick = tick + 1;
  }
  if (tick == published.tick) return false;
  if (view.info->clock_mode != client::ClockMode::lockstep) {
    if (now < published.due) return false;
    const auto period =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate_));
    // A late message does not shift those that follow, unless it is later than a whole period.
    published.due += period;
    if (published.due < now) published.due = now + period;
    return true;
  }
  if (tick != published.waiting) {
    published.waiting = tick;
    published.waiting_since = now;
  }
  const double passed = (static_cast<double>(tick) - static_cast<double>(published.tick)) *
                        std::chrono::duration<double>(view.info->period).count();
  return passed * rate_ >= 1.0 || passed < 0.0 || now - published.waiting_since >= kEndOfStep;
}

void JointPublisher::publish_diagnostics(const Board::Views& views, Clock::time_point now) {
  std::string content;
  for (const auto& [number, view] : views) {
    content += (view.state ? 'a' : 's') + view.problem;
    if (!view.state) continue;
    for (const client::AxisSnapshot& axis : view.state->axes) {
      const auto [level, message] = level_of(view, axis);
      content += std::to_string(level) + message;
    }
  }
  if (now < diagnostics_due_ && content == last_diagnostics_) return;
  diagnostics_due_ = now + kDiagnostics;
  last_diagnostics_ = std::move(content);
  (void)diagnostics_.write(diagnostics_of(views, network_));
}

}  // namespace vdrive::ros2

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "reports.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client/session.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::ros2 {

/// A bench in lock-step with a period of 1 ms, without a network or a plant: a drive shows its
/// set-points as demand values, and has no other state.
class FakeBench {
 public:
  static constexpr std::uint64_t kSession = 0x0A;  ///< the bridge's session
  static constexpr std::uint64_t kBegin = 1000;    ///< first tick

  /// @param names of the axes
  explicit FakeBench(std::vector<std::string> names, std::uint32_t number = 1)
      : names_(std::move(names)) {
    info_.number = number;
    info_.incarnation = number;
    info_.clock_mode = ClockMode::lockstep;
    state_.tick = kBegin;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const client::AxisId id{number, static_cast<std::uint16_t>(i + 1)};
      info_.axes.emplace_back();
      info_.axes[i].id = id;
      info_.axes[i].name = names_[i];
      info_.axes[i].unit.size = 2'000.0 * std::numbers::pi;  // 0.001 rad per user unit
      state_.axes.emplace_back().id = id;
      show(i, PowerState::switch_on_disabled);
    }
  }

  [[nodiscard]] const client::BenchInfo& info() const { return info_; }

  client::BenchInfo& info() { return info_; }

  /// Joints whose user unit is 0.001 rad.
  [[nodiscard]] std::vector<ServedJoint> joints() const {
    std::vector<ServedJoint> joints;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      joints.push_back(
          {.name = names_[i], .axis = info_.axes[i].id, .unit = {}, .si_per_user_unit = 0.001});
    }
    return joints;
  }

  /// -10 to 10 rad, 5 rad/s, 50 rad/s², 3 N.m and 30 N.m/s.
  static JointLimits limits() {
    return {.lower = -10.0,
            .upper = 10.0,
            .velocity = 5.0,
            .acceleration = 50.0,
            .deceleration = 50.0,
            .ramp = 50.0,
            .effort = 3.0,
            .effort_per_mille = 0.003,
            .effort_slope = 30.0};
  }

  client::AxisSnapshot& axis(std::size_t place) { return state_.axes[place]; }

  [[nodiscard]] std::uint64_t tick() const { return state_.tick; }

  void show(std::size_t place, PowerState state) {
    state_.axes[place].status.ds402_statusword = statusword_of(state);
  }

  /// Shows all axes as enabled by the bridge.
  void enable() {
    for (std::size_t i = 0; i < state_.axes.size(); ++i) {
      state_.axes[i].owner_session = kSession;
      show(i, PowerState::operation_enabled);
    }
  }

  /// From now on, positions do not move a drive.
  void hold_streams() { holds_streams_ = true; }

  /// From now on, drives refuse to change their mode.
  void keep_modes() { keeps_modes_ = true; }

  /// From now on, drives change their mode after this delay.
  void delay_modes(std::uint64_t ticks) { mode_delay_ = ticks; }

  /// Stands in for a link: takes the wishes of the bridge and passes on the state of the bench.
  void link(Bench& bench) {
    const Bench::Wishes wishes = bench.take_wishes();
    if (wishes.control) control_wishes_.push_back(*wishes.control);
    bench.set_state(std::make_shared<const client::Observation>(state_));
    bench.set_limits(std::make_shared<const std::vector<JointLimits>>(names_.size(), limits()),
                     wishes.limits);
  }

  /// @return the wishes that link() took, in order.
  [[nodiscard]] const std::vector<ControlWish>& control_wishes() const { return control_wishes_; }

  client::Outcome take(const std::vector<client::SetPointFrame>& frames) {
    for (const client::SetPointFrame& frame : frames) waiting_.push_back(frame);
    sent_.insert(sent_.end(), frames.begin(), frames.end());
    return client::Outcome{};
  }

  /// @return the frames sent since the previous call.
  std::vector<client::SetPointFrame> take_sent() { return std::exchange(sent_, {}); }

  /// Runs one tick and applies the frames that are due, including late ones.
  void step() {
    ++state_.tick;
    std::erase_if(waiting_, [this](const client::SetPointFrame& frame) {
      if (frame.tick > state_.tick) return false;
      for (const client::SetPoint& point : frame.axes) apply(point);
      return true;
    });
    std::erase_if(late_modes_, [this](const auto& late) {
      if (late.second.tick > state_.tick) return false;
      state_.axes[late.first - 1U].status.op_mode_actual =
          static_cast<std::int8_t>(late.second.mode);
      return true;
    });
  }

  /// Jumps to this tick and drops the waiting frames.
  void count_from(std::uint64_t tick) {
    state_.tick = tick;
    waiting_.clear();
    late_modes_.clear();
  }

 private:
  /// A mode that is not yet active.
  struct LateMode {
    OperatingMode mode = OperatingMode::none;
    std::uint64_t tick = 0;  ///< in which it becomes active
  };

  void take_mode(std::uint16_t number, OperatingMode mode) {
    if (keeps_modes_) return;
    if (axis(number - 1U).mode() == mode) {
      late_modes_.erase(number);
      return;
    }
    LateMode& late = late_modes_[number];
    if (late.mode != mode) late = {.mode = mode, .tick = state_.tick + mode_delay_};
  }

  void apply(const client::SetPoint& point) {
    client::AxisSnapshot& axis = state_.axes[point.axis - 1U];
    if (point.mode) take_mode(point.axis, *point.mode);
    if (point.position && !holds_streams_) axis.status.position_demand_value = *point.position;
    if (point.torque) axis.status.torque_demand = *point.torque;
    axis.status.velocity_demand_value = point.velocity.value_or(0);
    axis.status.ds402_statusword =
        static_cast<std::uint16_t>(axis.status.ds402_statusword | Statusword::kFollowsCommand);
    if (!point.controlword) return;
    PowerState state = PowerState::operation_enabled;
    if (*point.controlword == controlwords::kShutdown) state = PowerState::ready_to_switch_on;
    if (*point.controlword == controlwords::kSwitchOn) state = PowerState::switched_on;
    if (*point.controlword == Controlword::kFaultReset) state = PowerState::switch_on_disabled;
    axis.status.ds402_statusword = statusword_of(state);
  }

  std::vector<std::string> names_;
  client::BenchInfo info_;
  client::Observation state_;
  std::vector<client::SetPointFrame> waiting_;
  std::vector<client::SetPointFrame> sent_;
  std::vector<ControlWish> control_wishes_;
  std::map<std::uint16_t, LateMode> late_modes_;  ///< by axis number
  std::uint64_t mode_delay_ = 0;                  ///< [ticks]
  bool holds_streams_ = false;
  bool keeps_modes_ = false;
};

/// Reports, with the lines that were written.
struct WrittenReports {
  std::vector<std::string> lines;
  bridge::Reports reports{"test", [this](bridge::Severity, const std::string& line) {
                            lines.push_back(line);
                          }};
};

}  // namespace vdrive::ros2

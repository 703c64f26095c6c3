// SPDX-License-Identifier: Apache-2.0
#include "bench_power.hpp"

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/enabling_words.hpp"
#include "vdrive/cia402/power_state.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;

constexpr std::chrono::milliseconds kRepeatWords{500};

// The watchdog of a bench in lock-step counts drive time.
constexpr double kKeepAlive = 0.02;  // [s] of drive time

bool is_enabled(const client::AxisSnapshot& axis) {
  return axis.state() == PowerState::operation_enabled;
}

bool is_in_fault(const client::AxisSnapshot& axis) {
  return axis.state() == PowerState::fault || axis.state() == PowerState::fault_reaction_active;
}

/// @return the words that enable an axis again; none where nothing but a reset would help.
std::vector<std::uint16_t> words_to_enable(PowerState state, bool resets_fault) {
  if (state == PowerState::not_ready_to_switch_on || state == PowerState::fault_reaction_active) {
    return {};
  }
  // Transition 16: the axis keeps its power.
  if (state == PowerState::quick_stop_active) return {controlwords::kEnableOperation};
  std::vector<std::uint16_t> words;
  if (state == PowerState::fault) {
    if (!resets_fault) return {};
    words.push_back(Controlword::kFaultReset);
    state = PowerState::switch_on_disabled;
  }
  const auto rest = enabling_words(state);
  words.insert(words.end(), rest.begin(), rest.end());
  return words;
}

}  // namespace

BenchPower::BenchPower(std::uint64_t session, BenchLink& link, bridge::Reports& reports)
    : session_(session),
      link_(link),
      reports_(reports),
      to_enable_(link.joints().size()),
      was_in_fault_(link.joints().size()) {}

void BenchPower::want_enabled(bool wanted, bool resets_faults) {
  wants_enabled_ = wanted;
  resets_faults_ = wanted && resets_faults;
  to_enable_.assign(to_enable_.size(), wanted);
  has_to_give_back_ = has_to_give_back_ || wanted;
  link_.want_control(wanted);
  attempts_ = 0;
  words_due_ = {};
  words_tick_ = 0;
}

bool BenchPower::is_disabled(const BenchState& state) const {
  return std::ranges::none_of(state.axes, [this](const client::AxisSnapshot& axis) {
    return is_enabled(axis) && axis.owner_session == session_;
  });
}

void BenchPower::report_faults(const BenchState& state) {
  for (std::size_t i = 0; i < state.axes.size(); ++i) {
    const client::AxisSnapshot& axis = state.axes[i];
    const bool is_fault = is_in_fault(axis);
    if (is_fault && !was_in_fault_[i]) {
      reports_.report(Severity::error, "joint " + link_.joints()[i].name,
                      client::what_it_shows(axis));
    }
    was_in_fault_[i] = is_fault;
  }
}

BenchPower::Frames BenchPower::words(const BenchState& state, Clock::time_point now) {
  if (wants_enabled_) {
    return bridge::owns_all(state.axes, session_) ? enable(state, now) : Frames{};
  }
  if (!has_to_give_back_) return {};
  if (!is_disabled(state)) return disable(state);
  has_to_give_back_ = false;
  link_.give_back();
  return {};
}

BenchPower::Frames BenchPower::enable(const BenchState& state, Clock::time_point now) {
  constexpr std::size_t kWords = 4;
  constexpr int kMostAttempts = 10;
  if (now < words_due_ || state.tick == words_tick_) return {};
  Frames frames(kWords);
  for (std::size_t i = 0; i < to_enable_.size(); ++i) {
    const client::AxisSnapshot& axis = state.axes[i];
    const bool is_hopeless = axis.state() == PowerState::fault && !resets_faults_;
    if (is_enabled(axis) || is_hopeless) to_enable_[i] = false;
    if (!to_enable_[i]) continue;
    const auto words = words_to_enable(axis.state(), resets_faults_);
    for (std::size_t word = 0; word < words.size(); ++word) {
      frames[word].axes.push_back({.axis = axis_number(i), .controlword = words[word]});
    }
  }
  resets_faults_ = false;
  // The way of some axes is shorter than that of others.
  std::erase_if(frames, [](const client::SetPointFrame& frame) {
    return frame.axes.empty();
  });
  if (frames.empty()) return {};
  if (++attempts_ > kMostAttempts) {
    to_enable_.assign(to_enable_.size(), false);
    reports_.report(Severity::error, link_.name(), "its axes cannot be enabled");
    return {};
  }
  words_due_ = now + kRepeatWords;
  words_tick_ = state.tick;
  return frames;
}

BenchPower::Frames BenchPower::disable(const BenchState& state) {
  if (state.tick == words_tick_) return {};
  words_tick_ = state.tick;
  client::SetPointFrame frame{.drops_waiting = true};
  for (std::size_t i = 0; i < state.axes.size(); ++i) {
    const client::AxisSnapshot& axis = state.axes[i];
    if (axis.owner_session != session_ || !is_enabled(axis)) continue;
    frame.axes.push_back({.axis = axis_number(i), .controlword = controlwords::kShutdown});
  }
  return {frame};
}

bool BenchPower::is_keep_alive_due(const BenchState& state) {
  const bool is_needed = link_.info().clock_mode == client::ClockMode::lockstep && wants_enabled_ &&
                         std::ranges::any_of(state.axes, [this](const auto& axis) {
                           return axis.owner_session == session_;
                         });
  const double passed =
      (static_cast<double>(state.tick) - static_cast<double>(kept_alive_at_)) * link_.period();
  if (!is_needed || std::abs(passed) < kKeepAlive) return false;
  kept_alive_at_ = state.tick;
  return true;
}

}  // namespace vdrive::ros2

// SPDX-License-Identifier: Apache-2.0
#include "bench_power.hpp"

#include "control_keeper.hpp"
#include "joints.hpp"
#include "vdrive/client/command_words.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;

// A frame with controlwords may be lost or refused, and a drive may answer with another state. Half
// a second is long for a drive and short for a waiting operator.
constexpr std::chrono::milliseconds kRepeatWords{500};

// Five seconds of attempts; after that, the failure is reported.
constexpr int kMostAttempts = 10;

// In lock-step the watchdog of a bench counts drive time, but the session's own keep-alives follow
// wall time. The watchdog allows 500 ms unless configured otherwise: a step of a few tens of ticks
// must not use that up.
constexpr double kKeepAlive = 0.02;  // [s] of drive time

bool is_enabled(const client::AxisSnapshot& axis) {
  return axis.state() == PowerState::operation_enabled;
}

}  // namespace

BenchPower::BenchPower(std::uint64_t session, Bench& bench, bridge::Reports& reports)
    : session_(session),
      bench_(bench),
      reports_(reports),
      to_enable_(bench.joints().size()),
      was_in_fault_(bench.joints().size()) {}

void BenchPower::want_enabled(bool wanted, bool resets_faults) {
  wants_enabled_ = wanted;
  resets_faults_ = wanted && resets_faults;
  // to_enable_ and words_due_ are kept when enabling is cancelled: controlwords may still be in
  // flight, and the newest state may be older than they are.
  if (wanted) {
    to_enable_.assign(to_enable_.size(), true);
    words_due_ = {};
  }
  has_to_give_back_ = has_to_give_back_ || wanted;
  bench_.wish(wanted ? ControlWish::take : ControlWish::leave);
  attempts_ = 0;
  words_tick_ = 0;
}

bool BenchPower::is_disabled(const client::Observation& state) const {
  for (std::size_t i = 0; i < state.axes.size(); ++i) {
    const bool may_be_enabled = is_enabled(state.axes[i]) || (!wants_enabled_ && to_enable_[i]);
    if (may_be_enabled && state.axes[i].owner_session == session_) return false;
  }
  return true;
}

void BenchPower::report_faults(const client::Observation& state) {
  for (std::size_t i = 0; i < state.axes.size(); ++i) {
    const client::AxisSnapshot& axis = state.axes[i];
    const bool is_in_fault = is_fault(axis.state());
    if (is_in_fault && !was_in_fault_[i]) {
      reports_.report(Severity::error, bench_.joints()[i].label(), client::what_it_shows(axis));
    }
    was_in_fault_[i] = is_in_fault;
  }
}

BenchPower::Frames BenchPower::words(const client::Observation& state, Clock::time_point now) {
  if (wants_enabled_) {
    return bridge::owns_all(state.axes, session_) ? enable(state, now) : Frames{};
  }
  if (!has_to_give_back_) return {};
  forget_old_words(state, now);
  if (!is_disabled(state)) return disable(state);
  has_to_give_back_ = false;
  bench_.wish(ControlWish::give_back);
  return {};
}

/// Accounts for controlwords sent before enabling was cancelled: an axis released before they act
/// would be enabled without a master. Most act within a tick or two.
void BenchPower::forget_old_words(const client::Observation& state, Clock::time_point now) {
  for (std::size_t i = 0; i < to_enable_.size(); ++i) {
    if (is_enabled(state.axes[i]) || now >= words_due_) to_enable_[i] = false;
  }
}

BenchPower::Frames BenchPower::enable(const client::Observation& state, Clock::time_point now) {
  // Once per tick: the newest state would be the same, and the controlwords would be sent twice.
  if (now < words_due_ || state.tick == words_tick_) return {};
  Frames frames;
  for (std::size_t i = 0; i < to_enable_.size(); ++i) {
    const client::AxisSnapshot& axis = state.axes[i];
    const bool is_hopeless = axis.state() == PowerState::fault && !resets_faults_;
    if (is_enabled(axis) || is_hopeless) to_enable_[i] = false;
    if (!to_enable_[i]) continue;
    // A drive without transition 16 does not react to the first attempt. At rest, it may be enabled
    // through a state without power.
    const bool keeps_power = attempts_ == 0 || axis.status.velocity_demand_value != 0;
    auto points =
        client::set_points_to(client::EachCommand::enable, axis,
                              {.resets_fault = resets_faults_, .keeps_power = keeps_power});
    // An axis that keeps its power may still be braking, and a change of mode would change how it
    // brakes.
    const bool keeps_mode = axis.state() == PowerState::quick_stop_active && keeps_power;
    if (!points.empty() && !keeps_mode) put_mode(i, points.back());
    frames.resize(std::max(frames.size(), points.size()));  // some need more words than others
    for (std::size_t n = 0; n < points.size(); ++n) {
      frames[n].axes.push_back(std::move(points[n]));
    }
  }
  resets_faults_ = false;  // a fault that recurs needs a person
  if (frames.empty()) return {};
  if (++attempts_ > kMostAttempts) {
    to_enable_.assign(to_enable_.size(), false);
    reports_.report(Severity::error, bench_.label(), "its axes cannot be enabled");
    return {};
  }
  words_due_ = now + kRepeatWords;
  words_tick_ = state.tick;
  return frames;
}

/// Some drives change their mode only when they have no power (5E20h:05). The mode is sent with the
/// last controlword, in Switched on, because some drives do not accept it in a fault either.
void BenchPower::put_mode(std::size_t place, client::SetPoint& last) const {
  const auto interface = bench_.joints()[place].interface.value_or(CommandInterface::position);
  const client::SetPoint point = begin_stream(last.axis, mode_of(interface));
  last.mode = point.mode;
  last.objects.insert(last.objects.begin(), point.objects.begin(), point.objects.end());
}

BenchPower::Frames BenchPower::disable(const client::Observation& state) {
  if (state.tick == words_tick_) return {};
  // Set-points waiting for their tick must not act after the controlword.
  client::SetPointFrame frame{.drops_waiting = true};
  for (std::size_t i = 0; i < state.axes.size(); ++i) {
    const client::AxisSnapshot& axis = state.axes[i];
    if (axis.owner_session != session_ || !is_enabled(axis)) continue;
    frame.axes.push_back(client::set_points_to(client::EachCommand::disable, axis).front());
  }
  if (frame.axes.empty()) return {};
  words_tick_ = state.tick;
  return {frame};
}

bool BenchPower::is_keep_alive_due(const client::Observation& state) {
  const bool is_needed = bench_.info().clock_mode == client::ClockMode::lockstep &&
                         wants_enabled_ &&
                         std::ranges::any_of(state.axes, [this](const auto& axis) {
                           return axis.owner_session == session_;
                         });
  // Absolute value, because a bench whose ticks start again from a lower number needs keep-alives
  // too.
  const double passed =
      (static_cast<double>(state.tick) - static_cast<double>(kept_alive_at_)) * bench_.period();
  if (!is_needed || std::abs(passed) < kKeepAlive) return false;
  kept_alive_at_ = state.tick;
  return true;
}

}  // namespace vdrive::ros2

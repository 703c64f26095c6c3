// SPDX-License-Identifier: Apache-2.0
#include "control_keeper.hpp"

#include "vdrive/cia402/power_state.hpp"

#include <algorithm>

namespace vdrive::bridge {
namespace {

using client::AxisSnapshot;

bool is_foreign(const AxisSnapshot& axis, std::uint64_t own) {
  return axis.owner_session != 0 && axis.owner_session != own;
}

}  // namespace

std::optional<std::uint64_t> other_owner(std::span<const AxisSnapshot> axes, std::uint64_t own) {
  const auto other = std::ranges::find_if(axes, [own](const AxisSnapshot& axis) {
    return is_foreign(axis, own);
  });
  if (other == axes.end()) return std::nullopt;
  return other->owner_session;
}

bool owns_all(std::span<const AxisSnapshot> axes, std::uint64_t own) {
  return std::ranges::all_of(axes, [own](const AxisSnapshot& axis) {
    return axis.owner_session == own;
  });
}

void ControlKeeper::want(bool wanted) {
  const std::scoped_lock lock(mutex_);
  if (wanted && (!is_wanted_ || has_lost_)) is_new_ = true;
  is_wanted_ = wanted;
  had_it_ = false;
  has_lost_ = false;
}

bool ControlKeeper::is_wanted() const {
  const std::scoped_lock lock(mutex_);
  return is_wanted_;
}

std::optional<client::Observation> ControlKeeper::keep(std::span<const AxisSnapshot> axes,
                                                       Clock::time_point now) {
  if (!is_due(axes, now)) return std::nullopt;
  due_ = now + kRetry;
  if (const auto owner = other_owner(axes, session_)) {
    wait_for(*owner, axes);
    return std::nullopt;
  }
  if (const client::Outcome taken = bench_.acquire(); !taken) {
    note_refusal(taken, now);
    return std::nullopt;
  }
  retry_ = kRetry;
  auto held = bench_.observe();
  if (held) {
    note_owner(held->axes);
    report_taken(held->axes);
  }
  return held;
}

bool ControlKeeper::is_due(std::span<const AxisSnapshot> axes, Clock::time_point now) {
  note_owner(axes);
  const std::scoped_lock lock(mutex_);
  if (!is_wanted_ || has_lost_ || owns_all(axes, session_)) return false;
  if (is_new_) {
    is_new_ = false;
    reported_ = {};
    retry_ = kRetry;
    due_ = {};
  }
  return now >= due_;
}

/// Notes whether this session has control, and reports its loss.
void ControlKeeper::note_owner(std::span<const AxisSnapshot> axes) {
  if (!has_just_lost(axes)) return;
  // Without the lock: getting the name may take time.
  const auto owner = other_owner(axes, session_);
  const std::string loss = owner ? bench_.name_of(*owner) + " has taken control of its axes"
                                 : "control of its axes was lost";
  bench_.report(Severity::error, loss + ": " + remedies_.loss);
}

bool ControlKeeper::has_just_lost(std::span<const AxisSnapshot> axes) {
  const std::scoped_lock lock(mutex_);
  if (!is_wanted_ || has_lost_) return false;
  // The state of a paused bench contains no owner.
  if (!std::ranges::all_of(axes, &AxisSnapshot::has_owner)) return false;
  const bool has_it = owns_all(axes, session_);
  has_lost_ = had_it_ && !has_it;
  had_it_ = had_it_ || has_it;
  return has_lost_;
}

void ControlKeeper::wait_for(std::uint64_t owner, std::span<const AxisSnapshot> axes) {
  if (owner == reported_.owner) return;
  reported_.owner = owner;
  const auto count = std::ranges::count_if(axes, [this](const AxisSnapshot& axis) {
    return is_foreign(axis, session_);
  });
  bench_.report(Severity::warning,
                bench_.name_of(owner) + " controls " + std::to_string(count) + " of its " +
                    std::to_string(axes.size()) +
                    " axes: this bridge takes control when all of them are free");
}

void ControlKeeper::note_refusal(const client::Outcome& refusal, Clock::time_point now) {
  due_ = now + retry_;
  // A refusal is an event for all clients of the bench, so retries become less and less frequent.
  retry_ = std::min(2 * retry_, kLongestRetry);
  if (refusal.message() == reported_.refusal) return;
  reported_.refusal = refusal.message();
  bench_.report(Severity::warning, "cannot take control: " + refusal.message());
}

/// Reports that control was gained after a reported wait or refusal.
void ControlKeeper::report_taken(std::span<const AxisSnapshot> axes) {
  if (reported_.owner == 0 && reported_.refusal.empty()) return;
  std::string text = "taking control: ";
  text += reported_.owner == 0 ? "its axes are free"
                               : bench_.name_of(reported_.owner) + " no longer controls its axes";
  const auto faults = std::ranges::count_if(axes, [](const AxisSnapshot& axis) {
    return axis.state() == PowerState::fault || axis.state() == PowerState::fault_reaction_active;
  });
  if (faults > 0) {
    text += "; " + std::to_string(faults) + " of " + std::to_string(axes.size()) +
            " are in a fault: " + remedies_.faults;
  }
  reported_ = {};
  bench_.report(Severity::info, text);
}

}  // namespace vdrive::bridge

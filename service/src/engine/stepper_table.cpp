// SPDX-License-Identifier: Apache-2.0
#include "engine/stepper_table.hpp"

#include <algorithm>

namespace vdrive::service {

bool StepperTable::join(std::uint64_t session, const wire::Source& source, std::uint64_t tick,
                        Time now, std::size_t awaited) {
  if (find(session) != nullptr) return true;
  if (steppers_.size() == kMaxSteppers) return false;
  steppers_.push_back({.session = session, .source = source, .granted = tick, .last_message = now});
  awaited_ = std::max(awaited_, awaited);
  if (steppers_.size() >= awaited_) {
    is_complete_ = true;
  } else if (awaited > steppers_.size()) {
    is_complete_ = false;
  }
  note_waits(now);
  return true;
}

bool StepperTable::leave(std::uint64_t session, Time now) {
  const auto left = std::erase_if(steppers_, [&](const Stepper& stepper) {
    return stepper.session == session;
  });
  if (steppers_.empty()) {
    awaited_ = always_awaited_;
    is_complete_ = false;
  }
  note_waits(now);
  return left != 0;
}

Stepper* StepperTable::find(std::uint64_t session) noexcept {
  const auto found = std::ranges::find(steppers_, session, &Stepper::session);
  return found == steppers_.end() ? nullptr : &*found;
}

void StepperTable::note_message(std::uint64_t session, Time now) noexcept {
  if (Stepper* const stepper = find(session); stepper != nullptr) stepper->last_message = now;
}

void StepperTable::grant(Stepper& stepper, std::uint64_t ticks, Time now) noexcept {
  stepper.granted += ticks;
  note_waits(now);
}

const Stepper* StepperTable::slowest() const noexcept {
  const auto found = std::ranges::min_element(steppers_, {}, &Stepper::granted);
  return found == steppers_.end() ? nullptr : &*found;
}

const Stepper* StepperTable::silent(Time now) const noexcept {
  const auto found = std::ranges::find_if(steppers_, [&](const auto& stepper) {
    const Time since = std::max(stepper.last_message, stepper.waited_for_since);
    return stepper.is_waited_for && now - since >= kLongestSilence;
  });
  return found == steppers_.end() ? nullptr : &*found;
}

void StepperTable::note_waits(Time now) noexcept {
  const auto farthest = std::ranges::max_element(steppers_, {}, &Stepper::granted);
  for (auto& stepper : steppers_) {
    const bool is_behind = is_complete_ && stepper.granted < farthest->granted;
    if (is_behind && !stepper.is_waited_for) stepper.waited_for_since = now;
    stepper.is_waited_for = is_behind;
  }
}

}  // namespace vdrive::service

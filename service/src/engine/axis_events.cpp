// SPDX-License-Identifier: Apache-2.0
#include "engine/axis_events.hpp"

#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <bit>

namespace vdrive::service {

AxisEvents::Seen AxisEvents::Seen::of(const AxisStatus& status) noexcept {
  return {.statusword = status.ds402_statusword,
          .error_code = status.error_code,
          .ignored_set_points = status.ignored_set_points,
          .fault_count = status.fault_count};
}

AxisEvents::AxisEvents(BenchAxes& axes, const Masters& masters, FrameSchedule& schedule,
                       BenchEvents& events, Counters& counters)
    : axes_(axes),
      masters_(masters),
      schedule_(schedule),
      events_(events),
      counters_(counters),
      seen_(axes.size()),
      changed_((axes.size() + kWordSize - 1) / kWordSize) {
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    seen_[axis].statusword = axes.bank().status(axis).ds402_statusword;
  }
}

/// All axes are compared in each tick, and usually nothing has changed: the threads share this
/// comparison. Changes are then reported in the order of the axes.
void AxisEvents::report_changes() {
  axes_.share(changed_.size(), [this](std::size_t first, std::size_t last) {
    for (std::size_t word = first; word < last; ++word) changed_[word] = changes_of(word);
  });
  for (std::size_t word = 0; word < changed_.size(); ++word) {
    for (std::uint64_t left = changed_[word]; left != 0; left &= left - 1U) {
      report(word * kWordSize + static_cast<std::size_t>(std::countr_zero(left)));
    }
  }
}

std::uint64_t AxisEvents::changes_of(std::size_t word) const noexcept {
  const std::size_t first = word * kWordSize;
  const std::size_t count = std::min(kWordSize, seen_.size() - first);
  const auto statuses = axes_.bank().statuses().subspan(first, count);
  std::uint64_t changed = 0;
  for (std::size_t n = 0; n < count; ++n) {
    const AxisStatus& status = statuses[n];
    const Seen& seen = seen_[first + n];
    const bool is_changed =
        ((status.ds402_statusword ^ seen.statusword) & Statusword::kState) != 0 ||
        status.error_code != seen.error_code ||
        status.ignored_set_points != seen.ignored_set_points ||
        status.fault_count != seen.fault_count;
    changed |= std::uint64_t{is_changed} << n;
  }
  return changed;
}

void AxisEvents::report(std::size_t axis) {
  const AxisStatus& status = axes_.bank().status(axis);
  Seen& seen = seen_[axis];
  if (((status.ds402_statusword ^ seen.statusword) & Statusword::kState) != 0) {
    report_state(axis, status, seen);
  }
  if (status.fault_count != seen.fault_count) report_faults(axis, status, seen);
  if (status.ignored_set_points != seen.ignored_set_points) report_set_points(axis, status, seen);
  seen = Seen::of(status);
}

void AxisEvents::report_state(std::size_t axis, const AxisStatus& status, const Seen& seen) {
  const PowerState before = decode_power_state(seen.statusword);
  events_.report({.kind = msg::EventKind::state_changed,
                  .axis = axes_.number_of(axis),
                  .code = status.ds402_statusword,
                  .error_register = status.error_register});
  if (before == PowerState::fault) {
    events_.report({.kind = msg::EventKind::fault_reset,
                    .axis = axes_.number_of(axis),
                    .code = seen.error_code,
                    .error_register = status.error_register});
  }
  if (before == PowerState::operation_enabled && schedule_.size() > 0) {
    schedule_.cancel_of_axis(axes_.number_of(axis));
  }
}

/// The count can fall when the axis is power-cycled or a snapshot is restored.
void AxisEvents::report_faults(std::size_t axis, const AxisStatus& status, const Seen& seen) {
  if (status.fault_count < seen.fault_count) return;
  events_.report({.kind = msg::EventKind::fault,
                  .axis = axes_.number_of(axis),
                  .code = status.error_code,
                  .error_register = status.error_register});
}

void AxisEvents::report_set_points(std::size_t axis, const AxisStatus& status, const Seen& seen) {
  if (status.ignored_set_points < seen.ignored_set_points) return;
  const std::uint32_t more = status.ignored_set_points - seen.ignored_set_points;
  counters_.set_points_ignored.add(more);
  events_.report({.kind = msg::EventKind::set_point_ignored,
                  .axis = axes_.number_of(axis),
                  .session = masters_.owner(axis).session,
                  .detail = Count{more}});
}

}  // namespace vdrive::service

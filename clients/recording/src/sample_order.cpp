// SPDX-License-Identifier: Apache-2.0
#include "sample_order.hpp"

#include "recording.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::recording {

void SampleOrder::note(const client::AxisId& axis, std::uint64_t tick) {
  const auto [known, is_first] = benches_.try_emplace(axis.bench);
  Ticks& ticks = known->second;
  if (!is_first && tick < ticks.newest.number) {
    throw RecordingError("the tick " + std::to_string(tick) + " of the axis " + to_string(axis) +
                         " follows the tick " + std::to_string(ticks.newest.number) +
                         " of its bench: a part of the file is duplicated or out of order");
  }
  if (!is_first && tick > ticks.newest.number) ticks.before = std::exchange(ticks.newest, {});
  ticks.newest.number = tick;
  if (!ticks.newest.axes.insert(axis.axis).second) {
    throw RecordingError("the axis " + to_string(axis) + " has the tick " + std::to_string(tick) +
                         " twice: a part of the file is duplicated");
  }
}

std::string SampleOrder::shortage(const client::Observation& last) const {
  if (last.axes.empty()) return {};
  const std::uint32_t number = last.axes.front().id.bench;
  const Ticks& ticks = benches_.at(number);
  const std::set<std::uint16_t>& before = ticks.before.axes;
  const bool is_part =
      ticks.newest.axes.size() < before.size() && std::ranges::includes(before, ticks.newest.axes);
  if (!is_part) return {};
  return "the tick " + std::to_string(last.tick) + " of bench " + std::to_string(number) + " has " +
         std::to_string(ticks.newest.axes.size()) + " of " + std::to_string(before.size()) +
         " axes";
}

}  // namespace vdrive::recording

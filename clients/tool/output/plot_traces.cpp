// SPDX-License-Identifier: Apache-2.0
#include "output/plot_traces.hpp"

#include <utility>

namespace vdrive::tool {
namespace {

/// @return the priority of a state among others in the same pixel column.
int weight_of(PowerState state) {
  if (is_fault(state)) return 2;
  return state == PowerState::quick_stop_active ? 1 : 0;
}

/// A constant value needs only its first and last point.
void add_point(std::vector<PlotPoint>& points, const PlotPoint& point) {
  const std::size_t count = points.size();
  if (count >= 1 && points[count - 1].tick == point.tick) return;
  const bool stays = count >= 2 && points[count - 2].value == point.value &&
                     points[count - 1].value == point.value;
  if (stays) {
    points.back() = point;
  } else {
    points.push_back(point);
  }
}

}  // namespace

PlotReduction::PlotReduction(const std::vector<PlotColumn>& columns, std::uint64_t first,
                             std::uint64_t last, std::size_t bins)
    : bins_(bins), ranges_(columns.size()) {
  traces_.first_tick = first;
  traces_.last_tick = last;
  traces_.traces.reserve(columns.size());
  for (const PlotColumn& column : columns) traces_.traces.push_back({.column = column});
}

void PlotReduction::take(const client::AxisSnapshot& sample) {
  // A fault that began before the left edge is not new at the edge.
  if (sample.tick < traces_.first_tick) error_ = sample.status.error_code;
  if (sample.tick < traces_.first_tick || sample.tick > traces_.last_tick) return;
  ++traces_.samples;
  // In floating point: the product of two 64-bit numbers may overflow.
  const double part = static_cast<double>(sample.tick - traces_.first_tick) /
                      (static_cast<double>(traces_.last_tick - traces_.first_tick) + 1.0);
  const auto bin = static_cast<std::uint64_t>(part * static_cast<double>(bins_));
  if (has_bin_ && bin != bin_) end_bin();
  if (!has_bin_) {
    begin_bin(sample);
    bin_ = bin;
  }
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const PlotPoint point{sample.tick, traces_.traces[i].column.member->value(sample.status)};
    Range& range = ranges_[i];
    if (point.value < range.lowest.value) range.lowest = point;
    if (point.value > range.highest.value) range.highest = point;
    range.newest = point;
  }
  take_state(sample);
  take_fault(sample);
}

PlotTraces PlotReduction::finish() && {
  if (has_bin_) {
    end_bin();
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      add_point(traces_.traces[i].points, ranges_[i].newest);
    }
  }
  return std::move(traces_);
}

void PlotReduction::begin_bin(const client::AxisSnapshot& sample) {
  has_bin_ = true;
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const PlotPoint point{sample.tick, traces_.traces[i].column.member->value(sample.status)};
    ranges_[i] = {.lowest = point, .highest = point, .newest = point};
  }
  state_ = {.from = sample.tick, .state = sample.state()};
}

void PlotReduction::end_bin() {
  has_bin_ = false;
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const Range& range = ranges_[i];
    const bool rises = range.lowest.tick <= range.highest.tick;
    add_point(traces_.traces[i].points, rises ? range.lowest : range.highest);
    add_point(traces_.traces[i].points, rises ? range.highest : range.lowest);
  }
  if (traces_.states.empty() || traces_.states.back().state != state_.state) {
    traces_.states.push_back(state_);
  }
}

void PlotReduction::take_state(const client::AxisSnapshot& sample) {
  const PowerState state = sample.state();
  if (state == state_.state || weight_of(state) < weight_of(state_.state)) return;
  state_ = {.from = sample.tick, .state = state};
}

void PlotReduction::take_fault(const client::AxisSnapshot& sample) {
  const std::uint16_t error = sample.status.error_code;
  const bool is_new = error != 0 && error != error_;
  error_ = error;
  if (!is_new) return;
  if (traces_.faults.size() < kMostPlotFaults) {
    traces_.faults.push_back({.tick = sample.tick, .code = error});
  } else {
    ++traces_.faults_left_out;
  }
}

}  // namespace vdrive::tool

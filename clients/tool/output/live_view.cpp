// SPDX-License-Identifier: Apache-2.0
#include "output/live_view.hpp"

#include "output/report.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <chrono>

namespace vdrive::tool {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPatienceOfView{200};  // also the longest delay at the end of a
                                                           // view
constexpr std::chrono::milliseconds kRefresh{50};
constexpr std::size_t kBarWidth = 20;
constexpr std::size_t kWideTerminal = 110;

}  // namespace

std::string progress_bar(double fraction, std::size_t width) {
  const double bounded = std::clamp(fraction, 0.0, 1.0);
  const auto full = static_cast<std::size_t>(bounded * static_cast<double>(width));
  return "[" + std::string(full, '#') + std::string(width - full, '-') + "]";
}

LiveView::LiveView(client::Session& session, Terminal& terminal, std::vector<client::AxisId> axes)
    : session_(session), terminal_(terminal), axes_(std::move(axes)) {
  ensure(!axes_.empty(), "a view has axes to show");
  const auto bench = session_.find_bench(axes_.front().bench);
  if (bench) {
    ticks_per_line_ = client::ticks_of(std::chrono::seconds(1), bench->period);
    for (const client::AxisInfo& axis : bench->axes) units_[axis.id] = axis.unit;
  }
  thread_ = std::jthread([this](const std::stop_token& stop) {
    follow(stop);
  });
}

LiveView::~LiveView() {
  thread_.request_stop();
  thread_.join();
  terminal_.end_live();
}

void LiveView::aim(const client::AxisId& axis, std::int64_t target) {
  const std::scoped_lock lock(mutex_);
  const auto position = positions_.find(axis);
  aims_[axis] = {position == positions_.end() ? 0 : position->second, target};
}

void LiveView::follow(const std::stop_token& stop) {
  auto follower = session_.follow(axes_, client::Pace::observe);
  if (!follower) return;  // the commands themselves report the failure
  auto next_refresh = Clock::now();
  client::Observation last;
  while (!stop.stop_requested()) {
    auto sample = follower->next(kPatienceOfView);
    if (!sample) {
      if (sample.outcome().kind() == client::OutcomeKind::timed_out) continue;
      return;
    }
    note(*sample);
    last = *sample;
    const auto now = Clock::now();
    const bool is_due =
        terminal_.is_interactive() ? now >= next_refresh : sample->tick >= next_line_;
    if (!is_due) continue;
    next_refresh = now + kRefresh;
    next_line_ = sample->tick + ticks_per_line_;
    show(*sample);
  }
  if (!last.axes.empty() && terminal_.is_interactive()) show(last);  // remains on the screen
}

void LiveView::note(const client::Observation& sample) {
  const std::scoped_lock lock(mutex_);
  for (const client::AxisSnapshot& axis : sample.axes) {
    positions_[axis.id] = axis.status.load_position_actual_value;
  }
}

void LiveView::show(const client::Observation& sample) {
  std::vector<LiveLine> lines;
  for (const client::AxisSnapshot& axis : sample.axes) {
    lines.push_back(
        {bar_of(axis) + status_line(axis, to_string(axis.id), units_[axis.id]), color_of(axis)});
  }
  if (terminal_.is_interactive()) {
    terminal_.show_live(std::move(lines));
    return;
  }
  for (const LiveLine& line : lines) terminal_.print("    " + line.text);
}

std::string LiveView::bar_of(const client::AxisSnapshot& axis) {
  const std::scoped_lock lock(mutex_);
  const auto found = aims_.find(axis.id);
  if (found == aims_.end()) return {};
  const Aim& aim = found->second;
  if (aim.start == aim.target) return {};
  const double fraction = static_cast<double>(axis.status.load_position_actual_value - aim.start) /
                          static_cast<double>(aim.target - aim.start);
  std::string percent = std::to_string(static_cast<int>(std::clamp(fraction, 0.0, 1.0) * 100.0));
  percent.insert(0, 3 - std::min<std::size_t>(percent.size(), 3), ' ');
  const std::size_t width = terminal_size().columns < kWideTerminal ? kBarWidth / 2 : kBarWidth;
  const std::string bar = terminal_.is_interactive() ? progress_bar(fraction, width) + " " : "";
  return bar + percent + " %  ";
}

}  // namespace vdrive::tool

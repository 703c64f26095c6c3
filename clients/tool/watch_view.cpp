// SPDX-License-Identifier: Apache-2.0
#include "watch_view.hpp"

#include "report.hpp"
#include "watch_table.hpp"

#include <utility>

namespace vdrive::tool {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLinePeriod{100};
constexpr std::chrono::milliseconds kTablePeriod{50};

}  // namespace

void WatchView::take(client::Observation sample) {
  newest_ = std::move(sample);
  is_new_ = true;
}

bool WatchView::refresh() {
  const bool is_other_size = form_ == Form::table && terminal_size() != shown_size_;
  const auto now = Clock::now();
  if ((!is_new_ && !is_other_size) || newest_.axes.empty() || now < due_) return false;
  due_ = now + (form_ == Form::table ? kTablePeriod : kLinePeriod);
  is_new_ = false;
  show();
  return true;
}

void WatchView::show() {
  if (form_ == Form::table) {
    shown_size_ = terminal_size();
    terminal_.show_screen(watch_table(newest_, names_, shown_size_));
    return;
  }
  for (const client::AxisSnapshot& axis : newest_.axes) {
    if (form_ == Form::json) {
      terminal_.print(to_line(status_json(axis, names_.at(axis.id))));
      continue;
    }
    const std::string line =
        std::to_string(axis.tick) + "  " + status_line(axis, to_string(axis.id));
    const auto color = color_of(axis);
    terminal_.print(color ? colored(terminal_, *color, line) : line);
  }
}

}  // namespace vdrive::tool

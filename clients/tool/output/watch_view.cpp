// SPDX-License-Identifier: Apache-2.0
#include "output/watch_view.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::tool {
namespace {

// A person reads no faster; lines stay in the terminal's memory, a table replaces itself.
constexpr std::chrono::milliseconds kLinePeriod{100};
constexpr std::chrono::milliseconds kTablePeriod{50};

}  // namespace

void WatchView::take(client::Observation sample) {
  if (sample.axes.empty()) return;
  newest_[sample.axes.front().id.bench] = std::move(sample);
  is_new_ = true;
}

/// The tick is that of the first bench; each axis has its own.
client::Observation WatchView::all() const {
  client::Observation all;
  for (const auto& [bench, sample] : newest_) {
    if (all.axes.empty()) all.tick = sample.tick;
    all.axes.insert(all.axes.end(), sample.axes.begin(), sample.axes.end());
  }
  return all;
}

bool WatchView::press(Key key) {
  constexpr int kSorts = static_cast<int>(WatchSort::state) + 1;
  const std::size_t page = std::max<std::size_t>(page_of(terminal_size()), 1);
  switch (key) {
    case Key::sort:
      choice_.sort = static_cast<WatchSort>((static_cast<int>(choice_.sort) + 1) % kSorts);
      break;
    case Key::reverse:
      choice_.is_reversed = !choice_.is_reversed;
      break;
    case Key::faults:
      choice_.only_faults = !choice_.only_faults;
      break;
    case Key::next_page:
      choice_.first = std::min(choice_.first + page, (faces_.size() - 1) / page * page);
      break;
    case Key::previous_page:
      choice_.first -= std::min(choice_.first, page);
      break;
    case Key::first_page:
      choice_.first = 0;
      break;
    case Key::quit:
      return false;
  }
  is_other_choice_ = true;
  return true;
}

bool WatchView::refresh(Clock::time_point now) {
  const bool is_other_size = form_ == Form::table && terminal_size() != shown_size_;
  if ((!is_new_ && !is_other_size && !is_other_choice_) || newest_.empty() || now < due_) {
    return false;
  }
  is_new_ = false;
  is_other_choice_ = false;
  if (form_ == Form::table) {
    show_table();
  } else if (!show_lines()) {
    return false;
  }
  due_ = now + (form_ == Form::table ? kTablePeriod : kLinePeriod);
  return true;
}

void WatchView::show_table() {
  shown_size_ = terminal_size();
  terminal_.show_screen(watch_table(all(), faces_, shown_size_, choice_));
}

/// The answer to a request and the status stream may both have a tick, such as the only one of a
/// bench that is paused.
bool WatchView::show_lines() {
  const client::Observation shown = all();
  std::vector<std::string> lines;
  for (const client::AxisSnapshot& axis : shown.axes) lines.push_back(line_of(axis));
  if (lines == shown_lines_) return false;
  for (const std::string& line : lines) terminal_.print(line);
  shown_lines_ = std::move(lines);
  return true;
}

std::string WatchView::line_of(const client::AxisSnapshot& axis) const {
  const AxisFace& face = face_of(axis.id, faces_);
  if (form_ == Form::json) return to_line(status_json(axis, face));
  const std::string line =
      std::to_string(axis.tick) + "  " + status_line(axis, to_string(axis.id), face.unit);
  const auto color = color_of(axis);
  return color ? colored(terminal_, *color, line) : line;
}

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
#include "output/watch_view.hpp"

#include "terminal/columns.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <span>
#include <utility>

namespace vdrive::tool {
namespace {

struct WatchedAxis {
  const client::AxisSnapshot& axis;
  const AxisLabel& label;
};

struct WatchColumn {
  std::string_view title;
  std::size_t from_width;   ///< narrowest terminal with this column [columns]
  std::size_t least_width;  ///< [columns]
  bool is_number;
  std::string (*cell)(const WatchedAxis&);
  bool needs_benches = false;  ///< shown only with axes of several benches
};

constexpr std::size_t kLongestName = 24;
constexpr std::size_t kHeaderRows = 2;

/// @return a position in the unit of the axis.
std::string in_unit(const WatchedAxis& watched, std::int32_t user_units) {
  return escaped(position_text(user_units, watched.label.unit));
}

constexpr std::array kColumns{
    WatchColumn{"axis", 0, 4, false,
                [](const WatchedAxis& watched) {
                  return to_string(watched.axis.id);
                }},
    WatchColumn{"name", 100, 4, false,
                [](const WatchedAxis& watched) {
                  return clipped(escaped(watched.label.name), kLongestName);
                }},
    WatchColumn{"bench", 100, 5, false,
                [](const WatchedAxis& watched) {
                  return clipped(escaped(watched.label.bench), kLongestName);
                },
                true},
    // Numbers have the width of usual values, because a column that changes its width would jump.
    WatchColumn{"position", 0, 11, true,
                [](const WatchedAxis& watched) {
                  return in_unit(watched, watched.axis.status.load_position_actual_value);
                }},
    WatchColumn{"in UU", 80, 9, true,
                [](const WatchedAxis& watched) {
                  return std::to_string(watched.axis.status.load_position_actual_value);
                }},
    WatchColumn{"demand", 160, 12, true,
                [](const WatchedAxis& watched) {
                  return in_unit(watched, watched.axis.status.position_demand_value);
                }},
    WatchColumn{"error", 160, 10, true,
                [](const WatchedAxis& watched) {
                  return in_unit(watched, watched.axis.status.load_position_error_value);
                }},
    WatchColumn{"velocity", 0, 12, true,
                [](const WatchedAxis& watched) {
                  return in_unit(watched, watched.axis.status.load_velocity_actual_value) + "/s";
                }},
    WatchColumn{"torque", 120, 8, true,
                [](const WatchedAxis& watched) {
                  return per_mille_text(watched.axis.status.torque_actual_value);
                }},
    WatchColumn{"mode", 160, 17, false,
                [](const WatchedAxis& watched) {
                  return std::string(to_string(watched.axis.mode()));
                }},
    WatchColumn{"word", 90, 6, false,
                [](const WatchedAxis& watched) {
                  return hex(watched.axis.status.ds402_statusword, 3);
                }},
    WatchColumn{"state", 0, 0, false,
                [](const WatchedAxis& watched) {
                  return state_text(watched.axis);
                }},
};

bool are_of_several_benches(std::span<const WatchedAxis> axes) {
  return std::ranges::any_of(axes, [&axes](const WatchedAxis& watched) {
    return watched.axis.id.bench != axes.front().axis.id.bench;
  });
}

/// The columns of a terminal, each as wide as its widest cell.
class WatchTable {
 public:
  WatchTable(std::span<const WatchedAxis> axes, std::size_t terminal_width)
      : width_(terminal_width - 1) {
    const bool has_benches = are_of_several_benches(axes);
    for (const WatchColumn& column : kColumns) {
      if (terminal_width < column.from_width || (column.needs_benches && !has_benches)) continue;
      std::size_t widest = std::max(column.least_width, column.title.size());
      for (const WatchedAxis& watched : axes) {
        widest = std::max(widest, display_width(column.cell(watched)));
      }
      columns_.emplace_back(&column, widest);
    }
  }

  [[nodiscard]] std::string header() const {
    return line_of([](const WatchColumn& column) {
      return std::string(column.title);
    });
  }

  [[nodiscard]] std::string row(const WatchedAxis& watched) const {
    return line_of([&](const WatchColumn& column) {
      return column.cell(watched);
    });
  }

 private:
  template <typename Cell>
  [[nodiscard]] std::string line_of(const Cell& cell) const {
    std::string line;
    for (const auto& [column, width] : columns_) {
      if (!line.empty()) line += column->is_number ? " " : "  ";
      const std::string text = cell(*column);
      line += column->is_number ? aligned_right(text, width) : padded(text, width);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    return clipped(line, width_);
  }

  std::size_t width_;
  std::vector<std::pair<const WatchColumn*, std::size_t>> columns_;
};

bool is_faulted(const WatchedAxis& watched) {
  return is_fault(watched.axis.state());
}

/// The last row, with the number of axes that the terminal has no room for.
LiveLine left_out(std::size_t count, std::size_t faults, std::size_t width) {
  const std::string text = "... " + counted(count, "more axis", "more axes");
  if (faults == 0) return {clipped(text, width), std::nullopt};
  return {clipped(text + ", " + std::to_string(faults) + " with a fault", width), Color::red};
}

/// @return the name of the sort order in the title.
std::string_view name_of_column(WatchSort sort) {
  constexpr std::array<std::string_view, 6> kNames{"axis",     "name",   "position",
                                                   "velocity", "torque", "state"};
  const auto place = static_cast<std::size_t>(sort);
  ensure(place < kNames.size(), "each order has a name");
  return kNames[place];
}

/// @return whether `a` is sorted before `b`.
bool is_before(const WatchedAxis& a, const WatchedAxis& b, WatchSort sort) {
  const AxisStatus& left = a.axis.status;
  const AxisStatus& right = b.axis.status;
  switch (sort) {
    case WatchSort::axis:
      return a.axis.id < b.axis.id;
    case WatchSort::name:
      return a.label.name < b.label.name;
    case WatchSort::position:
      return left.load_position_actual_value < right.load_position_actual_value;
    case WatchSort::velocity:
      return std::abs(std::int64_t{left.load_velocity_actual_value}) >
             std::abs(std::int64_t{right.load_velocity_actual_value});
    case WatchSort::torque:
      return std::abs(left.torque_actual_value) > std::abs(right.torque_actual_value);
    case WatchSort::state:
      if (is_faulted(a) != is_faulted(b)) return is_faulted(a);
      return a.axis.state() < b.axis.state();
  }
  return false;
}

/// @return the chosen axes in the chosen order; equal ones in the order of the sample.
std::vector<const WatchedAxis*> chosen(std::span<const WatchedAxis> axes,
                                       const WatchChoice& choice) {
  std::vector<const WatchedAxis*> rows;
  rows.reserve(axes.size());
  for (const WatchedAxis& watched : axes) {
    if (!choice.only_faults || is_faulted(watched)) rows.push_back(&watched);
  }
  std::ranges::stable_sort(rows, [&choice](const WatchedAxis* a, const WatchedAxis* b) {
    return choice.is_reversed ? is_before(*b, *a, choice.sort) : is_before(*a, *b, choice.sort);
  });
  return rows;
}

/// @return the tick; for several benches the number and tick of each.
std::string tick_text(const client::Observation& sample, std::span<const WatchedAxis> axes) {
  if (!are_of_several_benches(axes)) return "tick " + std::to_string(sample.tick);
  std::map<std::uint32_t, std::uint64_t> ticks;
  for (const WatchedAxis& watched : axes) ticks[watched.axis.id.bench] = watched.axis.tick;
  std::string text;
  for (const auto& [bench, tick] : ticks) {
    text += (text.empty() ? "bench " : ", bench ") + std::to_string(bench) + " tick " +
            std::to_string(tick);
  }
  return text;
}

std::string title_of(std::string title, const WatchChoice& choice) {
  if (choice.sort != WatchSort::axis || choice.is_reversed) {
    title.append(", by ").append(name_of_column(choice.sort));
    if (choice.is_reversed) title += " reversed";
  }
  return choice.only_faults ? title + ", faults only" : title;
}

/// @return the number of rows available for axes.
std::size_t room_of(const TerminalSize& size) {
  return std::max(size.rows, kHeaderRows + 1) - kHeaderRows;
}

}  // namespace

const AxisLabel& label_of(const client::AxisId& axis,
                          const std::map<client::AxisId, AxisLabel>& labels) {
  const auto label = labels.find(axis);
  ensure(label != labels.end(), "each axis that is watched has a label");
  return label->second;
}

std::size_t page_of(const TerminalSize& size) {
  return room_of(size) - 1;
}

std::vector<LiveLine> watch_table(const client::Observation& sample,
                                  const std::map<client::AxisId, AxisLabel>& labels,
                                  const TerminalSize& size, const WatchChoice& choice) {
  std::vector<WatchedAxis> axes;
  axes.reserve(sample.axes.size());
  for (const client::AxisSnapshot& axis : sample.axes)
    axes.push_back({axis, label_of(axis.id, labels)});
  const std::size_t width = size.columns - 1;
  const WatchTable table(axes, size.columns);
  std::vector<LiveLine> lines{
      {clipped(title_of(tick_text(sample, axes), choice), width), std::nullopt},
      {table.header(), Color::bold}};
  const std::vector<const WatchedAxis*> rows = chosen(axes, choice);
  if (rows.empty()) lines.push_back({clipped("no axis has a fault", width), std::nullopt});
  const bool fits = rows.size() <= room_of(size);
  const std::size_t page = fits ? rows.size() : page_of(size);
  const std::size_t last =
      rows.empty() ? 0 : (rows.size() - 1) / std::max<std::size_t>(page, 1) * page;
  const std::size_t first = fits ? 0 : std::min(choice.first, last);
  const std::size_t end = std::min(first + page, rows.size());
  std::size_t faults = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i >= first && i < end) {
      lines.push_back({table.row(*rows[i]), color_of(rows[i]->axis)});
    } else if (is_faulted(*rows[i])) {
      ++faults;
    }
  }
  if (!fits) lines.push_back(left_out(rows.size() - (end - first), faults, width));
  return lines;
}

namespace {

// Faster is not readable. Lines remain in the terminal's history, a table replaces itself.
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
      choice_.first = std::min(choice_.first + page, (labels_.size() - 1) / page * page);
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
  choice_changed_ = true;
  return true;
}

bool WatchView::refresh(Clock::time_point now) {
  const bool is_other_size = form_ == Form::table && terminal_size() != shown_size_;
  if ((!is_new_ && !is_other_size && !choice_changed_) || newest_.empty() || now < due_) {
    return false;
  }
  is_new_ = false;
  choice_changed_ = false;
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
  terminal_.show_screen(watch_table(all(), labels_, shown_size_, choice_));
}

/// Skips repeated lines: a tick, such as the only one of a paused bench, may arrive both in the
/// answer to a request and in the status stream.
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
  const AxisLabel& label = label_of(axis.id, labels_);
  if (form_ == Form::json) return to_line(status_json(axis, label));
  const std::string line =
      std::to_string(axis.tick) + "  " + status_line(axis, to_string(axis.id), label.unit);
  const auto color = color_of(axis);
  return color ? colored(terminal_, *color, line) : line;
}

}  // namespace vdrive::tool

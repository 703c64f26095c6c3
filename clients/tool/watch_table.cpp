// SPDX-License-Identifier: Apache-2.0
#include "watch_table.hpp"

#include "columns.hpp"
#include "report.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace vdrive::tool {
namespace {

/// An axis and its name.
struct WatchedAxis {
  const client::AxisSnapshot& axis;
  const std::string& name;
};

struct WatchColumn {
  std::string_view title;
  std::size_t from_width;   ///< narrowest terminal that has it [columns]
  std::size_t least_width;  ///< [columns]
  bool is_number;
  std::string (*cell)(const WatchedAxis&);
};

constexpr std::size_t kLongestName = 24;
constexpr std::size_t kHeaderRows = 2;

std::string number(std::int64_t value) {
  return std::to_string(value);
}

constexpr std::array kColumns{
    WatchColumn{"axis", 0, 4, false,
                [](const WatchedAxis& watched) {
                  return to_string(watched.axis.id);
                }},
    WatchColumn{"name", 100, 4, false,
                [](const WatchedAxis& watched) {
                  return clipped(escaped(watched.name), kLongestName);
                }},
    // The widths of numbers are those of usual values: a column that changed its width would jump.
    WatchColumn{"position", 0, 10, true,
                [](const WatchedAxis& watched) {
                  return number(watched.axis.status.load_position_actual_value);
                }},
    WatchColumn{"demand", 160, 10, true,
                [](const WatchedAxis& watched) {
                  return number(watched.axis.status.position_demand_value);
                }},
    WatchColumn{"error", 160, 8, true,
                [](const WatchedAxis& watched) {
                  return number(watched.axis.status.load_position_error_value);
                }},
    WatchColumn{"velocity", 0, 8, true,
                [](const WatchedAxis& watched) {
                  return number(watched.axis.status.load_velocity_actual_value);
                }},
    WatchColumn{"torque", 120, 8, true,
                [](const WatchedAxis& watched) {
                  return per_mille_text(watched.axis.status.torque_actual_value);
                }},
    WatchColumn{"mode", 160, 17, false,
                [](const WatchedAxis& watched) {
                  return std::string(to_string(watched.axis.mode()));
                }},
    WatchColumn{"word", 80, 6, false,
                [](const WatchedAxis& watched) {
                  return hex(watched.axis.status.ds402_statusword, 3);
                }},
    WatchColumn{"state", 0, 0, false,
                [](const WatchedAxis& watched) {
                  return state_text(watched.axis);
                }},
};

/// The columns of a terminal, each as wide as its widest cell.
class WatchTable {
 public:
  WatchTable(std::span<const WatchedAxis> axes, std::size_t terminal_width)
      : width_(terminal_width - 1) {
    for (const WatchColumn& column : kColumns) {
      if (terminal_width < column.from_width) continue;
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

/// The last row of a terminal that has no room for these axes.
LiveLine left_out(std::span<const WatchedAxis> axes, std::size_t width) {
  const auto faults = std::ranges::count_if(axes, [](const WatchedAxis& watched) {
    return color_of(watched.axis) == Color::red;
  });
  std::string text = "... " + counted(axes.size(), "more axis", "more axes");
  if (faults == 0) return {clipped(text, width), std::nullopt};
  return {clipped(text + ", " + std::to_string(faults) + " with a fault", width), Color::red};
}

}  // namespace

std::vector<LiveLine> watch_table(const client::Observation& sample,
                                  const std::map<client::AxisId, std::string>& names,
                                  const TerminalSize& size) {
  std::vector<WatchedAxis> axes;
  for (const client::AxisSnapshot& axis : sample.axes) axes.push_back({axis, names.at(axis.id)});
  const std::size_t width = size.columns - 1;
  const WatchTable table(axes, size.columns);
  std::vector<LiveLine> lines{
      {clipped("tick " + std::to_string(sample.tick) + ", positions in UU, velocities in UU/s",
               width),
       std::nullopt},
      {table.header(), Color::bold}};
  const std::size_t room = std::max(size.rows, kHeaderRows + 1) - kHeaderRows;
  const std::size_t shown = axes.size() <= room ? axes.size() : room - 1;
  for (std::size_t i = 0; i < shown; ++i) {
    lines.push_back({table.row(axes[i]), color_of(axes[i].axis)});
  }
  if (shown < axes.size()) lines.push_back(left_out(std::span(axes).subspan(shown), width));
  return lines;
}

}  // namespace vdrive::tool

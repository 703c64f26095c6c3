// SPDX-License-Identifier: Apache-2.0
#include "output/plot_columns.hpp"

#include "base/usage_error.hpp"
#include "values/value.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/quantity.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace vdrive::tool {
namespace {

/// How a quantity is drawn; curves with the same panel share a scale.
struct CurveRow {
  std::string_view variable_name;
  std::string_view word;
  std::string_view panel;  ///< without the unit for a position or a velocity
  double size = 1.0;
};

constexpr std::string_view kPositionPanel = "position";
constexpr std::string_view kVelocityPanel = "velocity";
constexpr std::string_view kTorquePanel = "torque and current [% of rated]";
constexpr std::string_view kErrorPanel = "following error";
constexpr std::string_view kVelocityErrorPanel = "velocity error";
constexpr double kPercentOfPerMille = 0.1;

/// All columns not listed here have a panel of their own.
constexpr std::array kCurves{
    CurveRow{"position_demand_value", "demand", kPositionPanel},
    CurveRow{"load_position_actual_value", "actual", kPositionPanel},
    CurveRow{"motor_position_actual_value", "motor", kPositionPanel},
    CurveRow{"velocity_demand_value", "demand", kVelocityPanel},
    CurveRow{"load_velocity_actual_value", "actual", kVelocityPanel},
    CurveRow{"motor_velocity_actual_value", "motor", kVelocityPanel},
    CurveRow{"torque_demand", "torque demand", kTorquePanel, kPercentOfPerMille},
    CurveRow{"torque_actual_value", "torque actual", kTorquePanel, kPercentOfPerMille},
    CurveRow{"current_actual_value", "current", kTorquePanel, kPercentOfPerMille},
    CurveRow{"load_position_error_value", "load", kErrorPanel},
    CurveRow{"motor_position_error_value", "motor", kErrorPanel},
    CurveRow{"load_velocity_error_value", "load", kVelocityErrorPanel},
    CurveRow{"motor_velocity_error_value", "motor", kVelocityErrorPanel},
    CurveRow{"current_error_value", "", "current error [mA]"},
    CurveRow{"ds402_statusword", "", "statusword"},
    CurveRow{"error_code", "", "error code"},
    CurveRow{"error_register", "", "error register"},
    CurveRow{"op_mode_actual", "", "operating mode"},
    CurveRow{"motor_op_status", "", "motor operation status"},
    CurveRow{"digital_inputs", "", "digital inputs"},
    CurveRow{"ignored_set_points", "", "ignored set-points"},
    CurveRow{"fault_count", "", "faults since power-up"},
};

constexpr std::array<std::string_view, 7> kUsualCurves{"position_demand_value",
                                                       "load_position_actual_value",
                                                       "velocity_demand_value",
                                                       "load_velocity_actual_value",
                                                       "torque_demand",
                                                       "torque_actual_value",
                                                       "load_position_error_value"};

PlotColumn column_of(const StatusMember& member) {
  const auto object = find_object(member.address);
  PlotColumn column{.member = &member,
                    .name = std::string(member.name),
                    .label = object ? index_text(member.address.index) : std::string()};
  // Remains the title of the panel of a member that is not listed in kCurves.
  column.panel = column.name;
  const auto* const curve = std::ranges::find(kCurves, column.name, &CurveRow::variable_name);
  if (curve == kCurves.end()) return column;
  column.panel = curve->panel;
  column.size = curve->size;
  if (!curve->word.empty()) column.label = std::string(curve->word) + " " + column.label;
  return column;
}

const std::vector<PlotColumn>& all_plot_columns() {
  static const std::vector<PlotColumn> columns = [] {
    std::vector<PlotColumn> all;
    for (const StatusMember& member : status_members()) {
      if (member.is_published) all.push_back(column_of(member));
    }
    return plot_columns_in(user_unit(), std::move(all));
  }();
  return columns;
}

const PlotColumn* column_named(std::string_view name) {
  const auto& columns = all_plot_columns();
  const auto found = std::ranges::find(columns, name, &PlotColumn::name);
  return found == columns.end() ? nullptr : &*found;
}

const PlotColumn& column_spelled(const std::string& text) {
  if (const PlotColumn* const column = column_named(text)) return *column;
  if (const auto row = parse_object(text).row()) {
    if (const PlotColumn* const column = column_named(describe(*row).variable_name)) return *column;
  }
  const std::vector<std::string> known = names_of_plot_columns();
  std::string hint = suggestion(text, known);
  if (hint.empty()) {
    for (const std::string& name : known) hint += (hint.empty() ? "; it has " : ", ") + name;
  }
  throw UsageError("--columns: a recording has no column " + in_quotes(text) + hint);
}

}  // namespace

std::vector<PlotColumn> usual_plot_columns() {
  std::vector<PlotColumn> columns;
  columns.reserve(kUsualCurves.size());
  for (const std::string_view name : kUsualCurves) columns.push_back(*column_named(name));
  return columns;
}

std::vector<PlotColumn> plot_columns_in(const Unit& unit, std::vector<PlotColumn> columns) {
  for (PlotColumn& column : columns) {
    const auto row = find_object(column.member->address);
    const auto dimension = row ? dimension_of(*row) : std::nullopt;
    if (!dimension) continue;
    column.panel = column_of(*column.member).panel + " [" + unit_name(*dimension, unit) + "]";
    column.size = from_user_units(1.0, unit);
  }
  return columns;
}

std::vector<PlotColumn> parse_plot_columns(std::string_view text) {
  std::vector<PlotColumn> columns;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string name(text.substr(begin, end - begin));
    const PlotColumn& column = column_spelled(name);
    if (std::ranges::find(columns, column.name, &PlotColumn::name) == columns.end()) {
      columns.push_back(column);
    }
    begin = end + 1;
  }
  return columns;
}

std::vector<std::string> names_of_plot_columns() {
  std::vector<std::string> names;
  names.reserve(all_plot_columns().size());
  for (const PlotColumn& column : all_plot_columns()) names.push_back(column.name);
  return names;
}

}  // namespace vdrive::tool

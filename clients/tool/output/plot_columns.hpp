// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/unit.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// A column of a recording, drawn as a curve.
struct PlotColumn {
  const StatusMember* member = nullptr;
  std::string name;     ///< in recordings: variable_name, or the name of a counter
  std::string label;    ///< in the legend, such as "demand 6062h"
  std::string panel{};  ///< title of its panel, may be shared, such as "position [UU]"
  double size = 1.0;    ///< of one unit of the recording, in the unit of the panel
};

/// @return position and velocity with their demand values, torque and following error.
[[nodiscard]] std::vector<PlotColumn> usual_plot_columns();

/// @return the columns with their panels converted to the unit of an axis, such as "position [mm]".
[[nodiscard]] std::vector<PlotColumn> plot_columns_in(const Unit& unit,
                                                      std::vector<PlotColumn> columns);

/// @param text names separated by commas: column names of a recording, or names and addresses of
///        objects as in every command
/// @return each column once, in this order.
/// @throws UsageError for an unknown name, with the nearest one or all names
[[nodiscard]] std::vector<PlotColumn> parse_plot_columns(std::string_view text);

/// @return the names of all columns that can be drawn.
[[nodiscard]] std::vector<std::string> names_of_plot_columns();

}  // namespace vdrive::tool

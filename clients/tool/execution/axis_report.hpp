// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/command_context.hpp"
#include "output/report.hpp"
#include "vdrive/client/axis.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace vdrive::tool {

/// What a command has done that the state of its axis does not show.
struct Deed {
  std::string text;  ///< such as "stored 91 parameters in ..."
  Json facts;        ///< the same as fields of JSON
};

/// What a command to an axis came to.
struct AxisReport {
  std::string_view command;  ///< its name
  client::Outcome outcome;
  bool has_arrived = false;     ///< what is left of the speed is the end of a motion
  bool names_next_step = true;  ///< a refusal by the power state names the command to call first
  std::optional<Deed> deed{};   ///< reported in the place of the state
};

/// @return the command that an axis in this state needs before it can move, such as "enable"; empty
///         in Operation enabled.
[[nodiscard]] std::string_view command_before_motion(PowerState state) noexcept;

/// Prints the report and what the axis shows now.
/// @return the outcome, in the words of the report.
client::Outcome report_axis(CommandContext& context, const client::Axis& axis, AxisReport report);

/// @param status what the axis shows now, none where it is not known
client::Outcome report_axis(CommandContext& context, const client::Axis& axis, AxisReport report,
                            const client::AxisSnapshot* status);

}  // namespace vdrive::tool

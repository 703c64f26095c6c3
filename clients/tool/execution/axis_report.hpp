// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/command_context.hpp"
#include "output/report.hpp"
#include "vdrive/client/axis.hpp"

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::tool {

/// What a command to an axis came to.
struct AxisReport {
  std::string_view command;  ///< its name
  client::Outcome outcome;
  bool has_arrived = false;      ///< what is left of the speed is the end of a motion
  bool names_next_step = true;   ///< a refusal by the power state names the command to call first
  std::optional<Record> deed{};  ///< what the state does not show, reported in its place
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

/// What failed of a command to several axes. Keeps the first failure for the caller, who prints it;
/// prints each further one once: the loss of a bench is the same failure for all its axes.
class AxisFailures {
 public:
  void take(client::Outcome reported, const CommandContext& context);

  [[nodiscard]] client::Outcome first() && { return std::move(first_); }

 private:
  std::set<std::string> messages_;
  client::Outcome first_;
};

}  // namespace vdrive::tool

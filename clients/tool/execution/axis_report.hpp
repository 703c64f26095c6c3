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

/// The result of a command to an axis.
struct AxisReport {
  std::string_view command;  ///< its name
  client::Outcome outcome;
  bool has_arrived = false;     ///< the motion has ended: the remaining speed is not shown
  bool names_next_step = true;  ///< a refusal because of the power state names the command needed
                                ///< first
  std::optional<Record> result_record{};  ///< reported in place of the state
};

/// @return the command that an axis in this state needs before it can move, such as "enable"; empty
///         in Operation enabled.
[[nodiscard]] std::string_view command_before_motion(PowerState state) noexcept;

/// Prints the report with the present status of the axis.
/// @return the outcome, with the message as it was reported.
client::Outcome report_axis(CommandContext& context, const client::Axis& axis, AxisReport report);

/// @param status present status of the axis, nullptr if unknown
client::Outcome report_axis(CommandContext& context, const client::Axis& axis, AxisReport report,
                            const client::AxisSnapshot* status);

/// Collects the failures of a command to several axes. Keeps the first one, which the caller
/// prints, and prints each different one once: the loss of a bench is the same failure for all its
/// axes.
class AxisFailures {
 public:
  void take(client::Outcome reported, const CommandContext& context);

  [[nodiscard]] client::Outcome first() && { return std::move(first_); }

 private:
  std::set<std::string> messages_;
  client::Outcome first_;
};

}  // namespace vdrive::tool

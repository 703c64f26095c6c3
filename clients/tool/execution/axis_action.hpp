// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/axis_report.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// Whether a command waits until it is done, or returns as soon as it is in force.
enum class Waits : std::uint8_t {
  always,
  unless_declined,  ///< except with --no-wait
  on_request        ///< only with --wait
};

/// The specifics of a command that takes axes and no other arguments.
struct AxisAction {
  std::string_view name;
  Waits waits = Waits::always;
  std::optional<client::EachCommand> together{};  ///< the command that several axes get in one
                                                  ///< request
  client::Outcome (*each)(client::Axis& axis) = nullptr;  ///< otherwise: the call made for each
                                                          ///< axis
  bool gains_control = false;
  bool names_next_step = true;  ///< see AxisReport

  /// Whether an axis has carried out the command, to show the progress of several axes; nullptr =
  /// the status does not show it.
  CommandProgress::AxisTest is_done = nullptr;

  /// The report in place of the state; nullptr = the state.
  Record (*result_record)(const client::Axis& axis) = nullptr;
};

/// The arguments of a command that takes only axes. Several axes get the command together; if it
/// fails for one of them, the others still get it.
struct AxisActionCommand {
  const AxisAction* action = nullptr;
  std::vector<std::string> axes{};
  client::Until until = client::Until::done;
  bool take_over = false;
  bool is_wait_given = false;
  bool keep_target = false;

  void declare(Arguments& arguments);

  /// @return the first failure; further ones are printed.
  client::Outcome run(CommandContext& context) const;
};

template <const AxisAction& action>
[[nodiscard]] AxisActionCommand action_command() {
  return {.action = &action};
}

/// The table row of a command that takes axes and no other arguments.
template <const AxisAction& action>
[[nodiscard]] consteval CommandRow action_row(CommandGroup group, std::string_view summary,
                                              std::string_view example) {
  return row_of<AxisActionCommand, &action_command<action>>(
      {.name = action.name, .group = group, .summary = summary, .example = example});
}

}  // namespace vdrive::tool

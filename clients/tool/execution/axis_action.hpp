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

/// Whether a command waits until it is done, or returns when it is in force.
enum class Waits : std::uint8_t {
  always,
  unless_declined,  ///< not with --no-wait
  on_request        ///< with --wait only
};

/// A command that takes axes and nothing else: what is particular about it.
struct AxisAction {
  std::string_view name;
  Waits waits = Waits::always;
  std::optional<client::EachCommand> together{};  ///< what several axes get with one request
  client::Outcome (*each)(client::Axis& axis) = nullptr;  ///< else what each gets by its own one
  bool gains_control = false;
  bool names_next_step = true;  ///< see AxisReport

  /// Whether an axis has done it, for the progress of many; none = its status does not show it.
  CommandProgress::AxisTest is_done = nullptr;

  /// What is reported in the place of the state; none = the state.
  Record (*deed)(const client::Axis& axis) = nullptr;
};

/// The arguments of such a command. Several axes get it together, and one that fails does not keep
/// it from the others.
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

/// The row of a command that takes axes and nothing else.
template <const AxisAction& action>
[[nodiscard]] consteval CommandRow action_row(CommandGroup group, std::string_view summary,
                                              std::string_view example) {
  return row_of<AxisActionCommand, &action_command<action>>(
      {.name = action.name, .group = group, .summary = summary, .example = example});
}

}  // namespace vdrive::tool

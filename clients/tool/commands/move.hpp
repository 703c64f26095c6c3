// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/units.hpp"

#include <optional>
#include <string>

namespace vdrive::tool {

/// A set-point of profile position mode.
struct MoveCommand {
  std::string axis{};
  Quantity position{};
  bool relative = false;
  std::optional<Quantity> velocity{};
  std::optional<Quantity> acceleration{};
  std::optional<Quantity> deceleration{};
  bool queue = false;
  client::Until until = client::Until::done;
  bool take_over = false;
  bool stop_on_interrupt = false;

  void declare(Arguments& arguments);
  void check_units(const CommandContext& context, const client::Axis& moved) const;
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool

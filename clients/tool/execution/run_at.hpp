// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "values/units.hpp"
#include "vdrive/client/axis.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::tool {

/// The arguments of a command that runs at a velocity (profile velocity mode).
struct RunAt {
  Quantity velocity{};
  std::optional<Quantity> acceleration{};
  std::optional<Quantity> deceleration{};
  bool take_over = false;

  /// With AXIS in front.
  void declare(Arguments& arguments, std::string& axis);

  /// @throws UsageError for a unit that the axis has not, and for what is out of range with it.
  void check_units(const AxisFinder& axes, const client::Axis& axis) const;

  /// @return [UU/s]
  [[nodiscard]] std::int32_t velocity_of(const AxisFinder& axes, const client::Axis& axis) const;

  [[nodiscard]] client::VelocityOptions options(const CommandContext& context,
                                                const client::Axis& axis,
                                                client::Until until) const;
};

}  // namespace vdrive::tool

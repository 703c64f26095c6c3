// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "values/units.hpp"
#include "vdrive/client/axis.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::tool {

/// The arguments of a command that runs an axis at a velocity (profile velocity mode).
struct VelocityArguments {
  Quantity velocity{};
  std::optional<Quantity> acceleration{};
  std::optional<Quantity> deceleration{};
  bool take_over = false;

  /// Declares AXIS, then these arguments.
  void declare(Arguments& arguments, std::string& axis);

  /// @throws UsageError for a unit that the axis does not have, and for a value that is out of
  ///         range after conversion from its unit.
  void check_units(const AxisFinder& axes, const client::Axis& axis) const;

  /// @return [UU/s]
  [[nodiscard]] std::int32_t velocity_of(const AxisFinder& axes, const client::Axis& axis) const;

  [[nodiscard]] client::VelocityOptions options(const CommandContext& context,
                                                const client::Axis& axis,
                                                client::Until until) const;
};

struct HomeCommand {
  std::string axis{};
  std::optional<std::int8_t> method{};  ///< 6098h
  std::optional<Quantity> offset{};
  std::optional<Quantity> search_speed{};
  std::optional<Quantity> creep_speed{};
  std::optional<Quantity> acceleration{};
  client::Until until = client::Until::done;
  bool take_over = false;

  void declare(Arguments& arguments);
  void check_units(const CommandContext& context, const client::Axis& homed) const;
  client::Outcome run(CommandContext& context) const;
};

struct VelocityCommand {
  std::string axis{};
  VelocityArguments run_at{};
  client::Until until = client::Until::done;

  void declare(Arguments& arguments);
  void check_units(const CommandContext& context, const client::Axis& driven) const;
  client::Outcome run(CommandContext& context) const;
};

struct TorqueCommand {
  std::string axis{};
  std::int16_t torque = 0;               ///< [‰ of rated torque]
  std::optional<std::uint32_t> slope{};  ///< [‰ of rated torque per second]
  client::Until until = client::Until::done;
  bool take_over = false;

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
};

struct JogCommand {
  std::string axis{};
  VelocityArguments run_at{};
  std::optional<Duration> duration{};  ///< none = until Enter is pressed or an interrupt

  void declare(Arguments& arguments);
  void check_units(const CommandContext& context, const client::Axis& driven) const;
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool

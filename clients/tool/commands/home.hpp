// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/units.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::tool {

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

}  // namespace vdrive::tool

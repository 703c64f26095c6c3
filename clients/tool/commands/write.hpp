// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/units.hpp"
#include "values/value.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::tool {

struct WriteCommand {
  std::string axis{};
  ObjectName object{};
  std::int64_t value = 0;
  std::optional<Quantity> quantity{};  ///< the value where it has a unit
  bool take_over = false;

  void declare(Arguments& arguments);
  void check_objects() const;
  void check_units(const CommandContext& context, const client::Axis& written) const;
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/expectation.hpp"

#include <string>

namespace vdrive::tool {

struct ExpectCommand {
  std::string axis{};
  Expectation expectation{};

  void declare(Arguments& arguments);
  void check_objects() const;
  void check_units(const CommandContext& context, const client::Axis& observed) const;
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool

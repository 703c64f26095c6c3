// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/value.hpp"

#include <string>
#include <vector>

namespace vdrive::tool {

struct ReadCommand {
  std::string axis{};
  std::vector<ObjectName> objects{};

  void declare(Arguments& arguments);
  void check_objects() const;
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool

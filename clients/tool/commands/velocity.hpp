// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/run_at.hpp"
#include "language/command.hpp"

#include <string>

namespace vdrive::tool {

struct VelocityCommand {
  std::string axis{};
  RunAt run_at{};
  client::Until until = client::Until::done;

  void declare(Arguments& arguments);
  void check_units(const CommandContext& context, const client::Axis& driven) const;
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool

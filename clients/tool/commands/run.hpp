// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "scenarios/scenario_files.hpp"

namespace vdrive::tool {

struct RunCommand {
  ScenarioFiles scenarios{};
  bool live = false;  ///< show the axes while time passes, also when not on a terminal

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
  ExitCode start(const Program& program) const;
};

}  // namespace vdrive::tool

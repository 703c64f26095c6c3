// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "output/junit.hpp"
#include "scenarios/private_benches.hpp"
#include "scenarios/scenario_files.hpp"
#include "scenarios/scenario_run.hpp"

namespace vdrive::tool {

struct RunCommand {
  ScenarioFiles scenarios{};
  bool live = false;        ///< show the axes while time passes, even if not on a terminal
  bool is_private = false;  ///< run each file on a new bench of this program
  PrivateBenches benches{};

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
  ExitCode start(const Program& program) const;

 private:
  ExitCode start_privately(const std::vector<Scenario>& loaded, JunitReport& junit,
                           const Program& program) const;
  ExitCode start_one_of_several(const Program& program) const;
  [[nodiscard]] RunOptions options_of_private_run(const Program& program) const;
  [[nodiscard]] std::vector<std::string> command_of_one(const Scenario& scenario,
                                                        const GlobalOptions& options) const;
};

}  // namespace vdrive::tool

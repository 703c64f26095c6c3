// SPDX-License-Identifier: Apache-2.0
#include "scenarios/scenario_files.hpp"

#include "language/arguments.hpp"
#include "language/variables.hpp"

namespace vdrive::tool {

void ScenarioFiles::declare(Arguments& arguments, const std::string& help) {
  arguments.positional("FILE", files, help).required();
  arguments.option("--set", "NAME=VALUE", settings,
                   "Value of the variable ${NAME}; may be repeated");
  arguments.option("--junit", "OUT.xml", junit, "Write a JUnit report");
}

std::vector<Scenario> ScenarioFiles::load(CommandTable commands) const {
  return load_scenarios(commands, files, settings_of(settings));
}

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "language/scenario.hpp"

#include <string>
#include <vector>

namespace vdrive::tool {

/// The arguments of a command that runs scenarios.
struct ScenarioFiles {
  std::vector<std::string> files{};     ///< - is standard input, a directory stands for all of its
                                        ///<   scenarios
  std::vector<std::string> settings{};  ///< of variables, such as axis=7.1
  std::string junit{};                  ///< file of the report; empty = none

  /// @param help of FILE
  void declare(Arguments& arguments, const std::string& help);

  /// @throws UsageError for a mistake in a file or setting, and for a directory without scenarios.
  [[nodiscard]] std::vector<Scenario> load(CommandTable commands,
                                           Mistake mistake = Mistake::refuses_all) const;

  /// @return the only file, whose text is on standard input. @throws UsageError as load()
  [[nodiscard]] Scenario load_from_input(CommandTable commands) const;
};

}  // namespace vdrive::tool

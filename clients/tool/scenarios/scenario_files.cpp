// SPDX-License-Identifier: Apache-2.0
#include "scenarios/scenario_files.hpp"

#include "base/usage_error.hpp"
#include "language/arguments.hpp"
#include "language/variables.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <system_error>

namespace vdrive::tool {
namespace {

constexpr const char* kEnding = ".scn";

/// @return the scenarios below a directory, sorted by name.
std::vector<std::string> files_below(const std::string& directory) {
  std::vector<std::string> files;
  std::error_code error;
  for (std::filesystem::recursive_directory_iterator at(directory, error), end; !error && at != end;
       at.increment(error)) {
    // A mounted ConfigMap contains each file a second time, below ..data.
    if (at->path().filename().string().starts_with('.')) {
      at.disable_recursion_pending();
      continue;
    }
    std::error_code unreadable;
    if (at->path().extension() == kEnding && at->is_regular_file(unreadable)) {
      files.push_back(at->path().string());
    }
  }
  if (error) {
    throw UsageError("cannot read the directory " + in_quotes(directory) + ": " + error.message());
  }
  if (files.empty()) {
    throw UsageError("the directory " + in_quotes(directory) + " has no scenario, *" + kEnding);
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace

void ScenarioFiles::declare(Arguments& arguments, const std::string& help) {
  arguments.positional("FILE", files, help + "; a directory stands for every *.scn below it")
      .required();
  arguments.option("--set", "NAME=VALUE", settings,
                   "Value of the variable ${NAME}; may be repeated");
  arguments.option("--junit", "OUT.xml", junit, "Write a JUnit report");
}

std::vector<Scenario> ScenarioFiles::load(CommandTable commands, Mistake mistake) const {
  std::vector<std::string> names;
  for (const std::string& file : files) {
    std::error_code unreadable;  // ignored: such a file is refused by name when it is opened
    if (std::filesystem::is_directory(file, unreadable)) {
      std::ranges::move(files_below(file), std::back_inserter(names));
    } else {
      names.push_back(file);
    }
  }
  return load_scenarios(commands, names, settings_of(settings), mistake);
}

Scenario ScenarioFiles::load_from_input(CommandTable commands) const {
  ensure(files.size() == 1, "one input has one name");
  return parse_scenario(commands, std::cin, files.front(), settings_of(settings));
}

}  // namespace vdrive::tool

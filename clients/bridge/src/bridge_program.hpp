// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <CLI/CLI.hpp>

#include <cerrno>
#include <exception>
#include <iostream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace vdrive::bridge {

/// The command-line handling shared by the bridges.

/// Exit codes.
inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;
inline constexpr int kUsage = 2;

/// @return the names of the options shown in the help, such as "--port".
[[nodiscard]] inline std::vector<std::string> names_of_options(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* const option : app.get_options()) {
    if (option->get_group().empty()) continue;
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// @return the message for an argument that no option takes.
[[nodiscard]] inline std::string unexpected_text(const CLI::App& app, const std::string& argument) {
  if (!argument.starts_with('-')) return in_quotes(argument) + " is one argument too many";
  const std::string name = argument.substr(0, argument.find('='));
  return in_quotes(name) + " is not an option" + suggestion(name, names_of_options(app));
}

/// Flushes standard output, because quick_exit() does not, and reports failure: output that got
/// lost is an error.
/// @return kDone, or kFailed after reporting that standard output could not be written.
[[nodiscard]] inline int conclude_output(std::string_view program) {
  if (std::cout.flush()) return kDone;
  std::cerr << program
            << ": standard output could not be written: " << std::generic_category().message(errno)
            << '\n';
  return kFailed;
}

/// Parses the command line and does the work; a failure is reported on standard error.
/// @tparam BadArguments thrown by `work` for unusable arguments
/// @return the exit code of `work`, kUsage or kFailed
template <typename BadArguments, typename Work>
[[nodiscard]] int run_program(CLI::App& app, int argument_count, const char* const* argument_list,
                              const Work& work) {
  const auto report = [&app](const std::exception& error) {
    std::cerr << prefixed_lines(app.get_name() + ": ", error.what()) << '\n';
  };
  try {
    app.parse(argument_count, argument_list);
    return work();
  } catch (const CLI::ExtrasError&) {
    std::cerr << app.get_name() << ": " << unexpected_text(app, app.remaining().front())
              << "\nRun with --help for more information.\n";
    return kUsage;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? conclude_output(app.get_name()) : kUsage;
  } catch (const BadArguments& error) {
    report(error);
    return kUsage;
  } catch (const std::exception& error) {
    report(error);
    return kFailed;
  }
}

}  // namespace vdrive::bridge

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include <cerrno>
#include <exception>
#include <iostream>
#include <string_view>
#include <system_error>

namespace vdrive::bridge {

/// The command line of a bridge: what the programs have in common.

/// Exit codes.
inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;
inline constexpr int kUsage = 2;

/// An answer that nobody has got is an error. Flushes: quick_exit() does not.
/// @return kDone, or kFailed after a report when standard output could not be written.
[[nodiscard]] inline int conclude_output(std::string_view program) {
  if (std::cout.flush()) return kDone;
  std::cerr << program
            << ": standard output could not be written: " << std::generic_category().message(errno)
            << '\n';
  return kFailed;
}

/// Parses the command line and does the work; a failure is reported on standard error.
/// @tparam BadArguments what `work` throws for arguments that cannot be used
/// @return the exit code: that of `work`, kUsage or kFailed
template <typename BadArguments, typename Work>
[[nodiscard]] int run_program(CLI::App& app, int argument_count, const char* const* argument_list,
                              const Work& work) {
  const auto report = [&app](const std::exception& error) {
    std::cerr << app.get_name() << ": " << error.what() << '\n';
  };
  try {
    app.parse(argument_count, argument_list);
    return work();
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

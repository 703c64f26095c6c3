// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include <exception>
#include <iostream>

namespace vdrive::bridge {

/// The command line of a bridge: what the programs have in common.

/// Exit codes.
inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;
inline constexpr int kUsage = 2;

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
    const bool is_help = app.exit(error) == 0;
    std::cout.flush();  // quick_exit() does not flush
    return is_help ? kDone : kUsage;
  } catch (const BadArguments& error) {
    report(error);
    return kUsage;
  } catch (const std::exception& error) {
    report(error);
    return kFailed;
  }
}

}  // namespace vdrive::bridge

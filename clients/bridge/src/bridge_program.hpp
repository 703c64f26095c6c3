// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <CLI/CLI.hpp>

#include <chrono>
#include <exception>
#include <iostream>

namespace vdrive::bridge {

/// The command line of a bridge: what the programs have in common.

/// Exit codes.
inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;
inline constexpr int kUsage = 2;

/// Declares the options that choose the network of `session`, except its domain.
inline void add_network_options(CLI::App& app, client::SessionOptions& session) {
  app.add_option("--interface", session.interfaces,
                 "Own address in a network to use for DDS; default: loopback only")
      ->type_name("ADDRESS");
  app.add_option("--peer", session.peers, "Host searched in addition to multicast")
      ->type_name("ADDRESS");
  app.add_option("--discovery-server", session.discovery_servers,
                 "Such as 10.0.0.9:11811, instead of multicast and peers")
      ->type_name("ADDRESS");
  app.add_option("--security", session.security,
                 "Closed mode of the benches: directory with certificate, key and permissions")
      ->envname("VDRIVE_SECURITY")
      ->type_name("DIR");
}

/// @return how long a bridge searches for benches in one go: in the closed mode a program that
///         misses the first message of an authentication gets the next one a second later.
[[nodiscard]] inline std::chrono::milliseconds find_timeout_of(
    const client::SessionOptions& session) {
  constexpr std::chrono::seconds kOpen{1};
  constexpr std::chrono::seconds kClosed{5};
  return session.security.empty() ? kOpen : kClosed;
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"
#include "vdrive/wire/ports.hpp"
#include "vdrive/wording.hpp"

#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::bridge {

/// The command-line options for the network, shared by the programs.

/// @return a validator for integers within these limits that accepts the number syntax of all our
///         programs: CLI11 alone would read 010 as octal and refuse 1e2.
[[nodiscard]] inline CLI::Validator whole_number(std::int64_t lowest, std::int64_t highest) {
  return {[lowest, highest](std::string& text) {
            return take_integer(text, lowest, highest);
          },
          ""};
}

/// Declares --domain.
/// @param further text in its help after the range
inline CLI::Option* add_domain_option(CLI::App& app, std::optional<std::uint32_t>& domain,
                                      const std::string& further = "") {
  return app
      .add_option("--domain", domain,
                  "DDS domain, 0 to " + std::to_string(wire::kHighestDomain) + further)
      ->transform(whole_number(0, wire::kHighestDomain))
      ->type_name("N");
}

/// Declares the options that select the network of `session`, except the domain.
/// @param interface_option another name for --interface, for programs with other interfaces too
inline void add_network_options(CLI::App& app, client::SessionOptions& session,
                                const std::string& interface_option = "--interface") {
  app.add_option(interface_option, session.interfaces,
                 "Own address or interface (eth0) in a network to use for DDS; default: loopback "
                 "only")
      ->type_name("ADDRESS");
  app.add_option("--peer", session.peers,
                 "Host, by address or name, to contact in addition to multicast")
      ->type_name("HOST");
  app.add_option("--discovery-server", session.discovery_servers,
                 "Such as 10.0.0.9:11811, instead of multicast and peers")
      ->type_name("HOST:PORT");
  app.add_option("--security", session.security,
                 "Closed mode of the benches: directory with certificate, key and permissions")
      ->envname("VDRIVE_SECURITY")
      ->type_name("DIR");
}

/// @return how long one search of a bridge for benches takes.
[[nodiscard]] inline std::chrono::milliseconds find_timeout_of(
    const client::SessionOptions& session) {
  constexpr std::chrono::seconds kOpen{1};
  return session.security.empty() ? kOpen : client::SessionOptions::kFindTimeoutOfClosedMode;
}

}  // namespace vdrive::bridge

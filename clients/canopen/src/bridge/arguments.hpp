// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bridge/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::canopen {

/// The options of vdrive-canopen, except those of the network, as given on the command line.
struct Arguments {
  std::vector<std::uint32_t> benches{};
  std::vector<std::int32_t> node_offsets{};  ///< one for all benches, or one per bench
  std::vector<std::string> socketcand{};
  std::vector<std::string> gateways{};
  std::vector<std::string> interfaces{};
  bool is_private = false;
  std::optional<std::size_t> axes{};
  std::optional<std::string> preset{};
  std::optional<std::string> bench_configuration{};
  std::optional<std::string> clock{};
  std::optional<std::string> sync_steps{};
  std::optional<std::string> state{};
  std::optional<std::string> journal{};
  std::optional<std::string> log{};
  std::vector<std::string> faults{};
};

/// @return the text of an option; empty if it was not given.
/// @throws settings::ConfigurationError for an empty text, for example from an unset shell
///         variable: the option would otherwise seem to be absent
[[nodiscard]] std::string text_of_option(const char* option,
                                         const std::optional<std::string>& text);

/// Applies the options, which override the settings of the file. Options of a bus are allowed only
/// if there is one bus.
/// @throws settings::ConfigurationError with option, value and limit
void apply_arguments(const Arguments& arguments, Settings& settings);

}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bridge/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::canopen {

/// The options of vdrive-canopen except those of the network, as they were written.
struct Arguments {
  std::vector<std::uint32_t> benches{};
  std::vector<std::int32_t> node_offsets{};  ///< one for all benches, or one each
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

/// @return the text of an option; empty when it was not given.
/// @throws settings::ConfigurationError when the text is empty, such as that of an unset variable
///         of a shell: it would be as if the option was not given
[[nodiscard]] std::string text_of_option(const char* option,
                                         const std::optional<std::string>& text);

/// Applies the options over what the file has said. Those of a bus are for the only one: they
/// replace what the file gives it.
/// @throws settings::ConfigurationError with option, value and limit
void apply_arguments(const Arguments& arguments, Settings& settings);

}  // namespace vdrive::canopen

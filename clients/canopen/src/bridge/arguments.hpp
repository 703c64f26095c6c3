// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bridge/settings.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::canopen {

/// The options of vdrive-canopen beside those of the network, as they were written.
struct Arguments {
  std::vector<std::uint32_t> benches{};
  std::vector<std::int32_t> node_offsets{};  ///< one for all benches, or one each
  std::vector<std::string> socketcand{};
  std::vector<std::string> gateways{};
  std::vector<std::string> interfaces{};
  bool is_private = false;
  std::optional<std::size_t> axes{};
  std::string bench_configuration{};
  std::string clock{};
  std::string sync_steps{};
  std::string state{};
};

/// Applies the options over what the file has said. Those of a bus are for the only one: they
/// replace what the file gives it.
/// @throws settings::ConfigurationError with option, value and limit
void apply_arguments(const Arguments& arguments, Settings& settings);

}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "directory.hpp"
#include "protocol.hpp"
#include "vdrive/client/session.hpp"

#include <string>
#include <vector>

namespace vdrive::gateway {

/// Without names a client gets all parameters of benches that have so many axes together, or fewer.
inline constexpr std::size_t kMostAxesOfAll = 16;

/// The parameters that a client asked for, and what went wrong.
struct ParameterAnswer {
  std::vector<Parameter> parameters;
  std::vector<std::string> complaints;  ///< each a sentence
};

/// @return the name of every object of every axis; none when these are more than kMostAxesOfAll.
[[nodiscard]] std::vector<std::string> all_parameters(const std::vector<KnownBench>& benches);

/// Reads parameters from their drives, those of an axis in one tick. Waits.
[[nodiscard]] ParameterAnswer read_parameters(client::Session& session,
                                              const std::vector<KnownBench>& benches,
                                              const std::vector<std::string>& names);

/// Writes parameters one after the other. Waits.
/// @return the values that the drives have then, and a complaint for each one that was refused.
[[nodiscard]] ParameterAnswer write_parameters(client::Session& session,
                                               const std::vector<KnownBench>& benches,
                                               const std::vector<ParameterChange>& changes);

}  // namespace vdrive::gateway

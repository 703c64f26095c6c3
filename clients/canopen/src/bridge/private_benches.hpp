// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bridge/settings.hpp"
#include "vdrive/bench/bench.hpp"

#include <vector>

namespace vdrive::canopen {

/// Reads the configurations of the private benches, and makes none.
/// @throws settings::ConfigurationError where a bench cannot be made of its options
void check_private_benches(const Settings& settings);

/// @return the benches of a private bridge, all on one local bus; empty where it is not private.
/// @throws bench::BenchError
[[nodiscard]] std::vector<bench::Bench> make_private_benches(const Settings& settings);

}  // namespace vdrive::canopen

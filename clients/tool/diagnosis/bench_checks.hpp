// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "diagnosis/finding.hpp"
#include "language/global_options.hpp"
#include "vdrive/client/bench.hpp"

#include <span>
#include <vector>

namespace vdrive::tool {

/// Judges the benches that were found on the domain.
[[nodiscard]] std::vector<Finding> check_benches(std::span<const client::BenchInfo> benches,
                                                 const GlobalOptions& options);

}  // namespace vdrive::tool

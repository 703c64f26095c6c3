// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "diagnosis/finding.hpp"
#include "diagnosis/host_readings.hpp"
#include "language/global_options.hpp"

#include <vector>

namespace vdrive::tool {

/// Judges what was read of the machine, for a use with these options.
[[nodiscard]] std::vector<Finding> check_host(const HostReadings& readings,
                                              const GlobalOptions& options);

}  // namespace vdrive::tool

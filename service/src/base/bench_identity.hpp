// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::service {

/// Identity of one run of a bench on the network.
struct BenchIdentity {
  std::uint32_t bench = 0;
  std::uint64_t incarnation = 0;  ///< start of the service [ns since 1970]
};

}  // namespace vdrive::service

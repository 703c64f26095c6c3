// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "seam/wire_region.hpp"
#include "supervision/wire_spawner.hpp"

namespace vdrive::service {

/// Everything that a service needs to run its wire in a separate process. Construct it before the
/// engine has threads and before it gives up its network access.
struct WireHost {
  explicit WireHost(const WireSettings& settings)
      : region(settings), spawner(region.descriptor()) {}

  WireRegion region;
  WireSpawner spawner;
};

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "seam/wire_region.hpp"
#include "supervision/wire_spawner.hpp"

namespace vdrive::service {

/// What a service needs to run its wire as a process: made before the engine has threads, and
/// before it gives the network away.
struct WireHost {
  explicit WireHost(const WireSettings& settings)
      : region(settings), spawner(region.descriptor()) {}

  WireRegion region;
  WireSpawner spawner;
};

}  // namespace vdrive::service

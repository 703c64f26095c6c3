// SPDX-License-Identifier: Apache-2.0
#include "run/bench_wire.hpp"

#include "publish/status_depth.hpp"

namespace vdrive::service {

WireSettings wire_settings(const Configuration& configuration) {
  WireSettings settings;
  settings.network = configuration.network;
  settings.bench = configuration.bench;
  settings.status_room = status_depth(configuration).room;
  return settings;
}

}  // namespace vdrive::service

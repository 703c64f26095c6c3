// SPDX-License-Identifier: Apache-2.0
#include "local_wire.hpp"

namespace vdrive::bench {

LocalWire::LocalWire(const service::Configuration& configuration, service::Counters& counters)
    : region_(service::wire_settings(configuration), service::WireRegion::Sharing::none),
      link_(region_),
      program_(region_, service::wire_settings(configuration)),
      counters_(counters) {
  link_.send_through(program_);
  counters.wire_starts.add();
}

void LocalWire::start() {
  link_.begin();
  counters_.wire_is_up.set(1);
}

void LocalWire::stop(std::chrono::milliseconds /*patience*/) {
  link_.end();
}

}  // namespace vdrive::bench

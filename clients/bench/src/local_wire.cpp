// SPDX-License-Identifier: Apache-2.0
#include "local_wire.hpp"

#include "publish/status_depth.hpp"

namespace vdrive::bench {
namespace {

service::WireSettings settings_of(const service::Configuration& configuration) {
  return {.network = configuration.network,
          .bench = configuration.bench,
          .log_level = "off",
          .status_room = service::status_depth(configuration).room};
}

}  // namespace

LocalWire::LocalWire(const service::Configuration& configuration, service::Counters& counters)
    : region_(settings_of(configuration), service::WireRegion::Sharing::none),
      link_(region_),
      program_(region_, settings_of(configuration)),
      counters_(counters) {
  link_.send_through(program_);
  counters.wire_starts.add();
}

void LocalWire::start() {
  link_.control().running_generation = 1;
  link_.control().state = service::WireState::running;
  counters_.wire_is_up.set(1);
}

void LocalWire::stop(std::chrono::milliseconds /*patience*/) {
  link_.control().state = service::WireState::none;
}

}  // namespace vdrive::bench

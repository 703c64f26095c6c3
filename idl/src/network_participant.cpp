// SPDX-License-Identifier: Apache-2.0
#include "network_participant.hpp"

#include "vdrive/wire/ports.hpp"

#include <atomic>

namespace vdrive::wire {
namespace {

/// Constant-initialised, because it is set before constructors run.
std::atomic<ParticipantMaker>& provided() noexcept {
  static constinit std::atomic<ParticipantMaker> maker{nullptr};
  return maker;
}

}  // namespace

void provide_network_participant(ParticipantMaker maker) noexcept {
  provided() = maker;
}

std::unique_ptr<Participant> make_network_participant(const NetworkSettings& settings,
                                                      const std::string& name) {
  NetworkSettings network = settings;
  if (settings.takes_default_domain) network.domain = default_domain();
  const ParticipantMaker maker = provided();
  if (maker == nullptr) {
    throw NetworkError(
        "this program has no DDS library, so it can reach only benches in the same process: pass "
        "the bus of a bench (SessionOptions::bus), or link vdrive::client, which has DDS (CMake: "
        "find_package(vdrive COMPONENTS client))");
  }
  return maker(network, name);
}

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#include "network_backend.hpp"

#include "vdrive/wire/ports.hpp"

#include <atomic>

namespace vdrive::wire {
namespace {

/// Initialised without code: it is set before constructors run.
std::atomic<BackendMaker>& provided() noexcept {
  static constinit std::atomic<BackendMaker> maker{nullptr};
  return maker;
}

}  // namespace

void provide_network_backend(BackendMaker maker) noexcept {
  provided() = maker;
}

std::unique_ptr<Backend> make_network_backend(const NetworkSettings& settings,
                                              const std::string& name) {
  NetworkSettings network = settings;
  if (settings.takes_default_domain) network.domain = default_domain();
  const BackendMaker maker = provided();
  if (maker == nullptr) {
    throw NetworkError(
        "this program has no DDS library, so it reaches benches of its own process only: give the "
        "session the bus of one (SessionOptions::bus), or link vdrive::client, which has DDS "
        "(CMake: find_package(vdrive COMPONENTS client))");
  }
  return maker(network, name);
}

}  // namespace vdrive::wire

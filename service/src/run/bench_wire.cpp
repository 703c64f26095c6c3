// SPDX-License-Identifier: Apache-2.0
#include "run/bench_wire.hpp"

#include "publish/status_depth.hpp"

#include <unistd.h>

#include <array>
#include <cstddef>
#include <string>

namespace vdrive::service {

namespace {

/// Contains the host name, because programs may run on several hosts and in containers, which have
/// their own host names.
std::string place_of_this_process() {
  constexpr std::size_t kLongestName = 64;  // of Linux
  std::array<char, kLongestName + 1> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) return {};
  return "process " + std::to_string(::getpid()) + " on " + host.data();
}

}  // namespace

WireSettings wire_settings(const Configuration& configuration) {
  WireSettings settings;
  settings.network = configuration.network;
  settings.bench = configuration.bench;
  settings.network.place = place_of_this_process();
  settings.status_room = status_depth(configuration).room;
  return settings;
}

}  // namespace vdrive::service

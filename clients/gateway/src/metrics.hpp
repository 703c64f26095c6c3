// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_watch.hpp"
#include "web_server.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::gateway {

/// The state of the gateway at one moment.
struct GatewayCounts {
  WebCounters web{};
  std::size_t channels = 0;        ///< topics
  std::size_t subscribed = 0;      ///< topics that a client receives
  std::size_t subscriptions = 0;   ///< of all clients
  std::uint64_t lost_batches = 0;  ///< dropped because the server's thread was late
  bool is_controlled = false;      ///< a client holds control
  std::vector<BenchPresence> benches{};
};

/// @return the counts as Prometheus text (exposition format 0.0.4).
[[nodiscard]] std::string metrics_text(const GatewayCounts& counts);

}  // namespace vdrive::gateway

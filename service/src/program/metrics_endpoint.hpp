// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/metrics.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace vdrive::service {

/// The answer to a probe: status 200 or 503, and the reason.
struct ProbeAnswer {
  bool is_good = false;
  std::string text;  ///< one line
};

/// The probes of a cluster. The thread of the endpoint calls them.
struct Probes {
  std::function<ProbeAnswer()> is_alive;  ///< if not, the service should be restarted
  std::function<ProbeAnswer()> is_ready;  ///< whether clients can use it
};

/// Serves metrics as Prometheus text (exposition format 0.0.4) at http://ADDRESS:PORT/metrics, and
/// answers to probes at /livez and /readyz, from a separate thread. A connection lasts at most 5 s
/// and carries one answer; when there are more than 64, the oldest is closed.
class MetricsEndpoint {
 public:
  /// @param address IPv4, of this machine
  /// @param port 0 = any free one
  /// @throws ConfigurationError if it cannot listen on this address and port
  MetricsEndpoint(const std::string& address, std::uint16_t port,
                  std::unique_ptr<const Metrics> metrics, Probes probes);

  /// Closes all connections immediately.
  ~MetricsEndpoint();
  MetricsEndpoint(const MetricsEndpoint&) = delete;
  MetricsEndpoint& operator=(const MetricsEndpoint&) = delete;

  [[nodiscard]] std::uint16_t port() const;

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/metrics.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace vdrive::service {

/// What a probe is told: status 200 or 503, and why.
struct ProbeAnswer {
  bool is_good = false;
  std::string text;  ///< a line
};

/// What a cluster asks of a service, called by the thread of the endpoint.
struct Probes {
  std::function<ProbeAnswer()> is_alive;  ///< if not it should be restarted
  std::function<ProbeAnswer()> is_ready;  ///< whether clients can use it
};

/// Serves metrics as Prometheus text (exposition format 0.0.4) at http://ADDRESS:PORT/metrics and
/// the answers to probes at /livez and /readyz, from a thread of its own. A connection lasts at
/// most 5 s and carries one answer; of more than 64 at once the oldest is closed.
class MetricsEndpoint {
 public:
  /// @param address IPv4, of this machine
  /// @param port 0 = any free one
  /// @throws ConfigurationError when address and port cannot be had.
  MetricsEndpoint(const std::string& address, std::uint16_t port,
                  std::unique_ptr<const Metrics> metrics, Probes probes);

  /// Ends at once, whoever is connected.
  ~MetricsEndpoint();
  MetricsEndpoint(const MetricsEndpoint&) = delete;
  MetricsEndpoint& operator=(const MetricsEndpoint&) = delete;

  [[nodiscard]] std::uint16_t port() const;

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace vdrive::service

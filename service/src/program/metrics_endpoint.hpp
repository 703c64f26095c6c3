// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/metrics.hpp"

#include <cstdint>
#include <memory>

namespace vdrive::service {

/// Serves metrics as Prometheus text (exposition format 0.0.4) at http://127.0.0.1:PORT/metrics,
/// from a thread of its own. A connection lasts at most 5 s and carries one answer; of more than 64
/// at once the oldest is closed.
class MetricsEndpoint {
 public:
  /// @param port 0 = any free one
  /// @throws ConfigurationError when the port cannot be had.
  MetricsEndpoint(std::uint16_t port, std::unique_ptr<const Metrics> metrics);

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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"
#include "configuration/configuration.hpp"
#include "seam/wire_link.hpp"
#include "seam/wire_region.hpp"

#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// How clients reach a bench: by DDS in a separate process or in threads of this one, or by the
/// local bus of this process. It is connected to the engine by the rings of its region.
class BenchWire {
 public:
  BenchWire() = default;
  virtual ~BenchWire() = default;
  BenchWire(const BenchWire&) = delete;
  BenchWire& operator=(const BenchWire&) = delete;

  [[nodiscard]] virtual const WireRegion& region() const noexcept = 0;
  [[nodiscard]] virtual WireLink& link() noexcept = 0;

  /// Starts the wire and returns when it runs.
  /// @throws wire::NetworkError
  virtual void start() = 0;

  /// @return the wall time needed to detect another service with the number of this bench.
  [[nodiscard]] virtual std::chrono::milliseconds duplicate_detection_time() const noexcept = 0;

  /// Restarts a wire that has failed. Call it regularly.
  virtual void supervise() {}

  /// @return the oldest unreported event about the wire, or nullopt.
  [[nodiscard]] virtual std::optional<EventRecord> next_news() { return std::nullopt; }

  /// @return whether no wire can be started any more.
  [[nodiscard]] virtual bool is_cut_off() const noexcept { return false; }

  /// @return the number of datagrams dropped by its guard.
  [[nodiscard]] virtual std::uint64_t datagrams_dropped() const { return 0; }

  /// Waits until the readers have received the reports, and announces the end.
  virtual void stop(std::chrono::milliseconds patience) = 0;
};

/// @return the settings of the wire of a bench, whatever its form.
[[nodiscard]] WireSettings wire_settings(const Configuration& configuration);

}  // namespace vdrive::service

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

/// How clients reach a bench: a process that names DDS, threads of this one, or the local bus of
/// this process. It meets the engine in the rings of its region.
class BenchWire {
 public:
  BenchWire() = default;
  virtual ~BenchWire() = default;
  BenchWire(const BenchWire&) = delete;
  BenchWire& operator=(const BenchWire&) = delete;

  [[nodiscard]] virtual const WireRegion& region() const noexcept = 0;
  [[nodiscard]] virtual WireLink& link() noexcept = 0;

  /// Returns when it runs.
  /// @throws wire::NetworkError
  virtual void start() = 0;

  /// @return wall time that shows whether another service has the number of this bench.
  [[nodiscard]] virtual std::chrono::milliseconds time_to_meet_others() const noexcept = 0;

  /// Again and again: starts a wire anew that has failed.
  virtual void supervise() {}

  /// @return what is to be reported about it, oldest first.
  [[nodiscard]] virtual std::optional<EventRecord> next_news() { return std::nullopt; }

  /// @return whether no wire can be started any more.
  [[nodiscard]] virtual bool is_cut_off() const noexcept { return false; }

  /// @return datagrams that its guard has dropped.
  [[nodiscard]] virtual std::uint64_t datagrams_dropped() const { return 0; }

  /// Waits until the readers have what was reported, and announces the end.
  virtual void stop(std::chrono::milliseconds patience) = 0;
};

/// @return how the wire of a bench is set up, whatever its form.
[[nodiscard]] WireSettings wire_settings(const Configuration& configuration);

}  // namespace vdrive::service

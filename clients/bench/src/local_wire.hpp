// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "configuration/configuration.hpp"
#include "run/bench_wire.hpp"
#include "seam/wire_link.hpp"
#include "seam/wire_region.hpp"
#include "wire/wire_program.hpp"

#include <chrono>

namespace vdrive::bench {

/// The wire that is none: what leaves the engine goes to the local bus in the thread that writes
/// it, and what arrives comes in the thread of the session that sends it.
class LocalWire final : public service::BenchWire {
 public:
  /// @param configuration its network names the bus
  /// @throws wire::NetworkError when another bench on the bus has the number
  LocalWire(const service::Configuration& configuration, service::Counters& counters);

  [[nodiscard]] const service::WireRegion& region() const noexcept override { return region_; }

  [[nodiscard]] service::WireLink& link() noexcept override { return link_; }

  void start() override;

  /// The bus knows whether a number is taken.
  [[nodiscard]] std::chrono::milliseconds time_to_meet_others() const noexcept override {
    return std::chrono::milliseconds{0};
  }

  void stop(std::chrono::milliseconds patience) override;

 private:
  service::WireRegion region_;
  service::WireLink link_;
  service::WireProgram program_;
  service::Counters& counters_;
};

}  // namespace vdrive::bench

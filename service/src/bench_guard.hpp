// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/service/bench_engine.hpp"
#include "vdrive/wire/subscription.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// Watches for another service with the same bench number. The one with the lower incarnation,
/// which started first, keeps the number.
class BenchGuard {
 public:
  /// How long to listen before announcing; running services show themselves every 50 ms.
  static constexpr std::chrono::milliseconds kListening{300};

  BenchGuard(wire::Participant& participant, const BenchIdentity& identity);

  /// @return the incarnation of the service to which the number belongs, when it is not ours.
  [[nodiscard]] std::optional<std::uint64_t> conflict() const noexcept;

 private:
  std::atomic<std::uint64_t> older_{0};  ///< 0 = none seen
  wire::Subscription<msg::BenchState> states_;
};

}  // namespace vdrive::service

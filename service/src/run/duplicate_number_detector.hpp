// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "seam/byte_ring.hpp"
#include "vdrive_messages.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// Watches for another service with the same bench number. The one with the lower incarnation,
/// which started first, keeps the number.
class DuplicateNumberDetector {
 public:
  /// How long to receive before announcing; running services publish their state every 50 ms.
  static constexpr std::chrono::milliseconds kReceiving{300};

  /// @param notices where the wire puts the states of other services
  DuplicateNumberDetector(ByteRing notices, const BenchIdentity& identity);

  /// Reads what has arrived. One thread at a time.
  void receive();

  /// @return the incarnation of the service to which the number belongs, when it is not ours.
  [[nodiscard]] std::optional<std::uint64_t> conflict() const noexcept;

 private:
  ByteRing notices_;
  BenchIdentity identity_;
  msg::BenchState state_;
  std::atomic<std::uint64_t> older_{0};  ///< 0 = none seen
};

}  // namespace vdrive::service

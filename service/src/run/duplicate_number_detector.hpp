// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "vdrive_messages.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>

namespace vdrive::service {

/// Detects another service with the same bench number. The one with the lower incarnation, which
/// started first, keeps the number.
class DuplicateNumberDetector {
 public:
  /// How long to listen before announcing; running services publish their state every 50 ms.
  static constexpr std::chrono::milliseconds kReceiving{300};

  explicit DuplicateNumberDetector(const BenchIdentity& identity) : identity_(identity) {}

  /// Notes a state from another service. One thread at a time.
  /// @param sample the state as it was published
  /// @param place where that service runs, as reported by it; may be empty
  void note(std::span<const std::byte> sample, std::span<const std::byte> place);

  /// @return the incarnation of the service that keeps the number, if it is not ours.
  [[nodiscard]] std::optional<std::uint64_t> conflict() const noexcept;

  /// @return in a conflict, a description of that service: "process 4711 on lab-pc (incarnation
  ///         17)".
  [[nodiscard]] std::string older_text() const;

 private:
  void keep_place(std::span<const std::byte> bytes);

  BenchIdentity identity_;
  msg::BenchState state_;
  std::atomic<std::uint64_t> older_{0};  ///< 0 = none seen
  mutable std::mutex mutex_;             ///< guards `place_`
  std::string place_;                    ///< of the older service
};

}  // namespace vdrive::service

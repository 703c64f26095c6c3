// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"

#include <cstdint>
#include <vector>

namespace vdrive::service {

/// Checks by counters of completed work that all threads make progress.
class Liveness {
 public:
  /// @param beats one counter per thread, outliving this object; empty = not alive
  explicit Liveness(const std::vector<const Counter*>& beats);

  /// @return whether every thread has completed something since the start.
  [[nodiscard]] bool has_begun() const noexcept;

  /// @return whether every thread has completed something since the last call.
  [[nodiscard]] bool has_advanced() noexcept;

 private:
  struct Watched {
    const Counter* beats = nullptr;
    std::uint64_t seen = 0;
  };

  std::vector<Watched> watched_;
};

}  // namespace vdrive::service

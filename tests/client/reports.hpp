// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace vdrive::test {

/// The reports that a program with its own loop keeps.
struct Reports {
  std::mutex mutex;
  std::vector<client::Observation> seen;  ///< guarded by the mutex

  [[nodiscard]] std::size_t count() {
    const std::scoped_lock lock(mutex);
    return seen.size();
  }

  /// @return whether that many reports arrive within 20 s.
  bool wait_for(std::size_t many) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (count() < many && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    return count() >= many;
  }

  [[nodiscard]] std::function<void(const client::Observation&)> keeper() {
    return [this](const client::Observation& observation) {
      const std::scoped_lock lock(mutex);
      seen.push_back(observation);
    };
  }
};

}  // namespace vdrive::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_bank.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

namespace vdrive::service {

/// Steps a bank with several threads: each takes a contiguous part of the groups, the calling
/// thread the first one. The result does not depend on the number of threads. Idle threads spin
/// briefly, then sleep.
class StepPool {
 public:
  /// @param threads including the calling one, at least 1; more than there are groups stay idle
  StepPool(AxisBank& bank, std::size_t threads);
  ~StepPool();
  StepPool(const StepPool&) = delete;
  StepPool& operator=(const StepPool&) = delete;

  /// One tick of the bank; returns when every group was stepped.
  void step() noexcept;

 private:
  void work(std::size_t part) noexcept;
  void step_part(std::size_t part) noexcept;

  AxisBank& bank_;
  std::size_t parts_;
  std::atomic<std::uint32_t> round_{0};
  std::atomic<std::uint32_t> unfinished_{0};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> helpers_;
};

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#include "step_pool.hpp"

#include <algorithm>

namespace vdrive::service {
namespace {

constexpr int kSpins = 2'000;

/// Waits until `value` is no longer `old`: spins, then sleeps.
std::uint32_t wait_for_change(const std::atomic<std::uint32_t>& value, std::uint32_t old) noexcept {
  for (int spin = 0; spin < kSpins; ++spin) {
    if (const std::uint32_t now = value.load(std::memory_order_acquire); now != old) return now;
  }
  value.wait(old, std::memory_order_acquire);
  return value.load(std::memory_order_acquire);
}

}  // namespace

StepPool::StepPool(AxisBank& bank, std::size_t threads)
    : bank_(bank), parts_(std::clamp<std::size_t>(threads, 1, bank.group_count())) {
  for (std::size_t part = 1; part < parts_; ++part) {
    helpers_.emplace_back([this, part] {
      work(part);
    });
  }
}

StepPool::~StepPool() {
  stop_ = true;
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (auto& helper : helpers_) helper.join();
}

void StepPool::step() noexcept {
  if (parts_ == 1) {
    bank_.step();
    return;
  }
  unfinished_.store(static_cast<std::uint32_t>(parts_ - 1), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  step_part(0);
  std::uint32_t left = unfinished_.load(std::memory_order_acquire);
  while (left != 0) left = wait_for_change(unfinished_, left);
}

void StepPool::work(std::size_t part) noexcept {
  std::uint32_t round = 0;
  while (true) {
    round = wait_for_change(round_, round);
    if (stop_) return;
    step_part(part);
    if (unfinished_.fetch_sub(1, std::memory_order_acq_rel) == 1) unfinished_.notify_one();
  }
}

void StepPool::step_part(std::size_t part) noexcept {
  const std::size_t groups = bank_.group_count();
  bank_.step_groups(groups * part / parts_, groups * (part + 1) / parts_);
}

}  // namespace vdrive::service

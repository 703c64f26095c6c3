// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "channel.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>

namespace vdrive::gateway {

/// Takes batches from the threads of the feeds over into the server's thread. When the server is
/// late, new batches are left out and counted: what it cannot send now it does not need later.
class BatchQueue {
 public:
  /// Batches that may be under way.
  static constexpr std::size_t kMost = 256;

  using Post = std::function<void(std::function<void()> action)>;
  using Take = std::function<void(const Batch& batch)>;

  /// @param post calls an action in the server's thread
  /// @param take receives the batches there
  BatchQueue(Post post, Take take) : post_(std::move(post)), take_(std::move(take)) {}

  /// Any thread; does not wait.
  void put(Batch batch);

  /// @return how many batches were left out. Any thread.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  const Post post_;
  const Take take_;
  std::atomic<std::size_t> under_way_ = 0;
  std::atomic<std::uint64_t> lost_ = 0;
};

}  // namespace vdrive::gateway

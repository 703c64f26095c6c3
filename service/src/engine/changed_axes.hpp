// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::service {

/// The axes whose parameters have changed since they were last sent, each once, in the order of
/// their first change. Fixed size: no allocation after construction.
class ChangedAxes {
 public:
  explicit ChangedAxes(std::size_t axes);

  void mark(std::size_t axis) noexcept;

  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }

  /// Removes and returns the axis that was marked first. Precondition: not `empty`.
  std::size_t take() noexcept;

 private:
  std::vector<std::uint16_t> queue_;  ///< circular
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::vector<bool> is_marked_;
};

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <span>

namespace vdrive::test {

/// Takes numbers from the fuzzer's bytes, most significant byte first; past the end they are 0.
class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> data) : data_(data) {}

  [[nodiscard]] bool empty() const { return data_.empty(); }

  template <typename Integer = std::uint8_t>
  Integer take() {
    std::uint64_t value = 0;
    for (const std::uint8_t byte : take_span(sizeof(Integer))) value = value << 8U | byte;
    return static_cast<Integer>(value);
  }

  /// @return a number below `bound`, which is 1 to 256.
  std::size_t below(std::size_t bound) { return take() % bound; }

  /// @return up to `count` bytes.
  std::span<const std::uint8_t> take_span(std::size_t count) {
    const auto taken = data_.first(std::min(count, data_.size()));
    data_ = data_.subspan(taken.size());
    return taken;
  }

 private:
  std::span<const std::uint8_t> data_;
};

/// Ends the run as a finding if `holds` is false.
inline void demand(bool holds, const char* what) {
  if (!holds) {
    std::cerr << "violated: " << what << '\n';
    std::abort();
  }
}

}  // namespace vdrive::test

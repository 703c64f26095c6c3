// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace vdrive::service {

/// Memory of this process of which the kernel gives a page when it is first written, and takes all
/// back at the end. The heap of the C library keeps what ends, and uses it again at other places: a
/// process that makes benches again and again would have touched all of it in the end. Not
/// reserved: a program of a thousand benches has some 26 GB of such memory and uses little of it.
/// If the kernel counted it, a fork of that program would fail.
class Pages {
 public:
  /// @param size [bytes]; @throws std::bad_alloc
  explicit Pages(std::size_t size);
  ~Pages();
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

  /// @return the memory, all zero at first.
  [[nodiscard]] std::span<std::byte> memory() const noexcept { return memory_; }

 private:
  std::span<std::byte> memory_;
};

}  // namespace vdrive::service

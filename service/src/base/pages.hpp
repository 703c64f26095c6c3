// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace vdrive::service {

/// Memory mapped for this object alone: the kernel provides a page when it is first written, and
/// gets all pages back when the object is destroyed. The heap of the C library would keep freed
/// pages and reuse them for other objects, so in a process that creates benches again and again,
/// more and more of the reserved memory would be in use.
///
/// Mapped with MAP_NORESERVE: a program with a thousand benches has some 26 GB of such memory and
/// uses little of it. If the kernel accounted for all of it, that program could not fork.
class Pages {
 public:
  /// @param size [bytes]; @throws std::bad_alloc
  explicit Pages(std::size_t size);
  ~Pages();
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

  /// @return the memory, initially zero.
  [[nodiscard]] std::span<std::byte> memory() const noexcept { return memory_; }

 private:
  std::span<std::byte> memory_;
};

}  // namespace vdrive::service

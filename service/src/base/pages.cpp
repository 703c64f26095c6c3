// SPDX-License-Identifier: Apache-2.0
#include "base/pages.hpp"

#include <sys/mman.h>

#include <new>

namespace vdrive::service {

Pages::Pages(std::size_t size) {
  if (size == 0) return;
  constexpr int kFlags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE;
  void* const memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, kFlags, -1, 0);
  // MAP_FAILED is a cast of -1.
  if (memory == MAP_FAILED) {  // NOLINT(*-cstyle-cast, performance-no-int-to-ptr)
    throw std::bad_alloc();
  }
  memory_ = {static_cast<std::byte*>(memory), size};
}

Pages::~Pages() {
  if (!memory_.empty()) munmap(memory_.data(), memory_.size());
}

}  // namespace vdrive::service

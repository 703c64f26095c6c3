// SPDX-License-Identifier: Apache-2.0
#include "core/support/allocation_guard.hpp"

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

thread_local bool armed = false;
thread_local std::uint64_t allocations = 0;

[[maybe_unused]] void count_allocation() noexcept {
  if (armed) ++allocations;
}

}  // namespace

namespace vdrive::test {

AllocationGuard::AllocationGuard() {
  allocations = 0;
  armed = true;
}

AllocationGuard::~AllocationGuard() {
  armed = false;
}

std::uint64_t AllocationGuard::count() const {
  return allocations;
}

}  // namespace vdrive::test

#if !defined(VDRIVE_SANITIZED) && defined(__GLIBC__)

// glibc's own entry points; the replacements below allocate through them. operator new of the
// standard library calls malloc and is counted there.
extern "C" {

void* __libc_malloc(std::size_t size);                           // NOLINT: glibc's name
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT: glibc's name
void* __libc_realloc(void* memory, std::size_t size);            // NOLINT: glibc's name
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT: glibc's name

void* malloc(std::size_t size) {
  count_allocation();
  return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
  count_allocation();
  return __libc_calloc(count, size);
}

void* realloc(void* memory, std::size_t size) {
  count_allocation();
  return __libc_realloc(memory, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count_allocation();
  return __libc_memalign(alignment, size);
}

}  // extern "C"

#elif !defined(VDRIVE_WATCHES_THREADS)

void* operator new(std::size_t size) {
  count_allocation();
  void* const memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void* operator new(std::size_t size, std::align_val_t alignment) {
  count_allocation();
  const auto step = static_cast<std::size_t>(alignment);
  void* const memory = std::aligned_alloc(step, (size + step - 1) / step * step);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void operator delete(void* memory) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

#endif

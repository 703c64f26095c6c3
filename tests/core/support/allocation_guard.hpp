// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::test {

/// Counts the allocations of this thread during its lifetime: operator new in every form and, where
/// no sanitizer owns them, malloc, calloc, realloc and aligned_alloc; nothing where the sanitizer
/// of threads owns all of them. Link allocation_guard.cpp.
class AllocationGuard {
 public:
  AllocationGuard();
  ~AllocationGuard();
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;
  AllocationGuard(AllocationGuard&&) = delete;
  AllocationGuard& operator=(AllocationGuard&&) = delete;

  [[nodiscard]] std::uint64_t count() const;
};

}  // namespace vdrive::test

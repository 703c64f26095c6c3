// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::test {

/// Counts the allocations of this thread during its lifetime: every form of operator new and, in
/// builds without a sanitizer, malloc, calloc, realloc and aligned_alloc. Under the thread
/// sanitizer, which owns all of them, it counts nothing. Link allocation_guard.cpp.
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

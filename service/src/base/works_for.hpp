// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::service {

/// While this object exists, the report of a broken invariant in this thread names the bench that
/// the thread works for (vdrive::worked_for): a process may have many benches.
class WorksFor {
 public:
  /// @param name for example "bench 3"; outlives this
  explicit WorksFor(const char* name) noexcept;
  ~WorksFor();
  WorksFor(const WorksFor&) = delete;
  WorksFor& operator=(const WorksFor&) = delete;

 private:
  const char* outer_;
};

}  // namespace vdrive::service

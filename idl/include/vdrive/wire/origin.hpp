// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::wire {

/// The process that made an object. A process that was forked has the memory of its parent and none
/// of its threads: nothing that has a thread, a lock, a socket or a file may be used there, not
/// even to end it. Thread-safe.
class Origin {
 public:
  /// This process.
  Origin();

  /// @return whether this process was forked (fork(2)) from the one that made the object. Costs no
  ///         system call.
  [[nodiscard]] bool is_inherited() const noexcept;

  /// @return why the object cannot be used, when it is inherited.
  /// @param what the object, such as "the bench"
  [[nodiscard]] std::string problem(std::string_view what) const;

 private:
  unsigned forks_;  ///< before this process, as far as they were seen
  pid_t process_;
};

/// Destroys an object in the process that made it. A forked process leaves the object as it is.
class DeleteInOrigin {
 public:
  template <typename Value>
  void operator()(Value* value) const noexcept {
    // NOLINTNEXTLINE(cppcoreguidelines-owning-memory): a deleter
    if (!origin_.is_inherited()) delete value;
  }

 private:
  Origin origin_;
};

/// @return a new object that a forked process never destroys.
template <typename Value, typename... Arguments>
std::shared_ptr<Value> made_here(Arguments&&... arguments) {
  auto made = std::make_unique<Value>(std::forward<Arguments>(arguments)...);
  return {made.release(), DeleteInOrigin()};
}

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::wire {

/// The process that created an object. A forked process has the memory of its parent but none of
/// its threads, so it must not use anything with a thread, lock, socket or file, not even to
/// destroy it. Thread-safe.
class Origin {
 public:
  /// This process.
  Origin();

  /// @return whether this process was forked (fork(2)) from the one that created the object. Makes
  ///         no system call.
  [[nodiscard]] bool is_inherited() const noexcept;

  /// @return why an inherited object cannot be used.
  /// @param what the object, such as "the bench"
  [[nodiscard]] std::string problem(std::string_view what) const;

 private:
  unsigned forks_;  ///< fork count (origin.cpp) of the creating process
  pid_t process_;
};

/// Destroys an object only in the process that created it. A forked process leaves it alone.
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"

#include <sys/types.h>

#include <atomic>
#include <memory>
#include <utility>

/// What a forked process does with what it inherits. It has the memory of its parent and none of
/// its threads: nothing that has a thread, a socket or a lock of the DDS library may be used there,
/// not even to end it. So the child leaves all of it as it is, for ever.
namespace vdrive::python {

/// The process that made an object.
class Origin {
 public:
  Origin();

  /// @return whether this process was forked from the one that made the object.
  [[nodiscard]] bool is_inherited() const noexcept;

  /// With the interpreter lock.
  /// @param what the object, such as "the session"
  /// @throws py::error_already_set with vdrive.Forked when it is inherited
  void require_own(const char* what) const;

 private:
  int generation_;
  pid_t process_;
};

/// Gives `value` up without its destructor, which must not run in this process.
template <typename Value>
void leave(Value&& value) noexcept {
  // On purpose, see above; a process without memory ends here.
  // NOLINTNEXTLINE(cppcoreguidelines-owning-memory, bugprone-unhandled-exception-at-new)
  static_cast<void>(new std::decay_t<Value>(std::forward<Value>(value)));
}

/// @return a new object, which a forked process never destroys.
template <typename Value, typename... Arguments>
std::shared_ptr<Value> made_here(Arguments&&... arguments) {
  auto made = std::make_unique<Value>(std::forward<Arguments>(arguments)...);
  return {made.release(), [origin = Origin()](Value* value) {
            // NOLINTNEXTLINE(cppcoreguidelines-owning-memory): of the line above
            if (!origin.is_inherited()) delete value;
          }};
}

/// Before a session is opened, with the interpreter lock: the DDS library does not survive a fork.
/// @throws py::error_already_set with vdrive.Forked when a process before this one had a session
void require_dds();

/// Calls what a forked process has to do at its begin.
void watch_forks();

}  // namespace vdrive::python

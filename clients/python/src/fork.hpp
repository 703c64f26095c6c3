// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "child_process.hpp"
#include "python.hpp"

#include <type_traits>
#include <utility>

/// Handling of objects in a forked process. The child has the memory of its parent, but none of its
/// threads: it must not use, or even destroy, any object with a thread, a socket or a lock of the
/// DDS library. So the child leaves all of them untouched, for ever.
namespace vdrive::python {

using process::made_here;

/// The process that created an object; its check raises the Python exception.
class Origin : public process::Origin {
 public:
  /// Call with the interpreter lock.
  /// @param what the object, such as "the session"
  /// @throws py::error_already_set with vdrive.Forked if the object was inherited
  void require_own(const char* what) const;
};

/// Abandons `value` without running its destructor, which must not run in this process.
template <typename Value>
void leave(Value&& value) noexcept {
  // Leaked on purpose, see above. If there is no memory left, noexcept ends the process.
  // NOLINTNEXTLINE(cppcoreguidelines-owning-memory, bugprone-unhandled-exception-at-new)
  static_cast<void>(new std::decay_t<Value>(std::forward<Value>(value)));
}

/// To be called before a session is opened, with the interpreter lock: the DDS library does not
/// survive a fork.
/// @throws py::error_already_set with vdrive.Forked if a parent process had a session
void require_dds();

/// From now on, a forked process skips the destructors of statics when it exits, if a DDS session
/// was opened before the fork.
void watch_forks();

}  // namespace vdrive::python

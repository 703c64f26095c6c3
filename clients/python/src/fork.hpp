// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "child_process.hpp"
#include "python.hpp"

#include <type_traits>
#include <utility>

/// What a forked process does with what it inherits. It has the memory of its parent and none of
/// its threads: nothing that has a thread, a socket or a lock of the DDS library may be used there,
/// not even to end it. So the child leaves all of it as it is, for ever.
namespace vdrive::python {

using process::made_here;

/// The process that made an object, with the exception of Python.
class Origin : public process::Origin {
 public:
  /// With the interpreter lock.
  /// @param what the object, such as "the session"
  /// @throws py::error_already_set with vdrive.Forked when it is inherited
  void require_own(const char* what) const;
};

/// Gives `value` up without its destructor, which must not run in this process.
template <typename Value>
void leave(Value&& value) noexcept {
  // On purpose, see above; a process without memory ends here.
  // NOLINTNEXTLINE(cppcoreguidelines-owning-memory, bugprone-unhandled-exception-at-new)
  static_cast<void>(new std::decay_t<Value>(std::forward<Value>(value)));
}

/// Before a session is opened, with the interpreter lock: the DDS library does not survive a fork.
/// @throws py::error_already_set with vdrive.Forked when a process before this one had a session
void require_dds();

/// A process that is forked after the first session over DDS ends without destructors of statics.
void watch_forks();

}  // namespace vdrive::python

// SPDX-License-Identifier: Apache-2.0
#include "fork.hpp"

#include "interpreter_lock.hpp"
#include "signal_watch.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

namespace vdrive::python {
namespace {

/// The process that opened the first session. Guarded by the interpreter lock.
std::optional<Origin>& first_session() {
  static std::optional<Origin> origin;
  return origin;
}

[[noreturn]] void raise_forked(const std::string& message) {
  const py::object kind = py::module_::import("vdrive._errors").attr("Forked");
  PyErr_SetObject(kind.ptr(), kind(message).ptr());
  throw py::error_already_set();
}

/// At exit, the destructors of the DDS library's statics would wait for threads that only the
/// parent has. Exit handlers run in reverse order of registration: this one, registered after the
/// fork, runs first and ends the process.
void end_without_statics(int status, void* /*unused*/) {
  static_cast<void>(std::fflush(nullptr));
  _exit(status);
}

void begin_child() {
  forget_calls_of_parent();
  forget_signals_of_parent();
  if (first_session()) on_exit(&end_without_statics, nullptr);
}

}  // namespace

void Origin::require_own(const char* what) const {
  if (!is_inherited()) return;
  raise_forked(problem(what) +
               ", and start that with multiprocessing.get_context(\"spawn\") or "
               "\"forkserver\"");
}

void require_dds() {
  if (!first_session()) first_session().emplace();
  if (!first_session()->is_inherited()) return;
  raise_forked("no session can be opened in process " + std::to_string(getpid()) +
               ": it was forked after its parent had opened one, and the DDS library does not "
               "survive a fork. Start it with multiprocessing.get_context(\"spawn\") or "
               "\"forkserver\", or fork before the first session");
}

void watch_forks() {
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") =
                                                         py::cpp_function(&begin_child));
}

}  // namespace vdrive::python

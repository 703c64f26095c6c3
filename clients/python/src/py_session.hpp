// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "errors.hpp"
#include "fork.hpp"
#include "interpreter_lock.hpp"
#include "python.hpp"
#include "signal_watch.hpp"
#include "vdrive/client/session.hpp"

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::python {

/// Something that must not outlive its session.
class Dependent {
 public:
  Dependent() = default;
  virtual ~Dependent() = default;
  Dependent(const Dependent&) = delete;
  Dependent& operator=(const Dependent&) = delete;

  /// Ends what uses the session; waits for calls of other threads that use it. Any thread. Does
  /// nothing in a forked process.
  virtual void close() noexcept = 0;

  const Origin origin{};
};

/// A session as Python has it: every handle keeps it, close() ends it before they go.
class PySession {
 public:
  /// @param bench kept until the session has ended; none where it is not of this program
  /// @throws std::runtime_error as client::Session does
  PySession(const client::SessionOptions& options, std::shared_ptr<void> bench)
      : bench_(std::move(bench)), session_(std::make_shared<client::Session>(options)) {}

  ~PySession() { close(); }

  PySession(const PySession&) = delete;
  PySession& operator=(const PySession&) = delete;

  /// A call that uses the session, which ends no earlier. Ends in the thread that began it.
  class Use {
   public:
    /// With the interpreter lock. @throws py::error_already_set as session()
    explicit Use(PySession& owner);
    ~Use();
    Use(Use&&) = default;
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    Use& operator=(Use&&) = delete;

    [[nodiscard]] client::Session& session() const noexcept { return *session_; }

   private:
    PySession* owner_;
    std::shared_ptr<client::Session> session_;  ///< nothing in one that was moved from
  };

  /// With the interpreter lock.
  /// @return the session, which ends no earlier than what is returned.
  /// @throws py::error_already_set when it was closed, and in a forked process
  [[nodiscard]] std::shared_ptr<client::Session> session() const;

  /// @return true also in a forked process.
  [[nodiscard]] bool is_closed() const;

  /// @return whether this process was forked from the one that opened the session.
  [[nodiscard]] bool is_inherited() const noexcept { return origin_.is_inherited(); }

  /// Closes `dependent` before the session, at once when that is closed.
  void adopt(const std::shared_ptr<Dependent>& dependent);

  /// As those of the session, while it is not closed. Any thread.
  void interrupt() noexcept;
  void end_interrupt() noexcept;

  /// Ends the calls of all threads, waits for those of others, and ends the session. A call that
  /// does not end, because a callback does not return, ends the session when it ends. Without the
  /// interpreter lock. Any thread. Does nothing in a forked process.
  void close() noexcept;

  /// The bench of calls that name none. Guarded by the interpreter lock.
  std::optional<std::uint32_t> only_bench;

  /// The queues to which the session reports events and services. Guarded by the interpreter lock.
  std::weak_ptr<Dependent> event_stream;
  std::weak_ptr<Dependent> service_stream;

 private:
  const Origin origin_;
  mutable std::mutex mutex_;  ///< whoever holds it never asks for the interpreter lock
  std::shared_ptr<void> bench_;
  std::shared_ptr<client::Session> session_;
  std::vector<std::thread::id> callers_;  ///< the thread of each Use
  std::condition_variable has_ended_;     ///< a Use
  std::vector<std::weak_ptr<Dependent>> dependents_;
};

using SharedPySession = std::shared_ptr<PySession>;

/// Without the interpreter lock, which it takes at its end. @throws what PySession throws
[[nodiscard]] SharedPySession open_py_session(const client::SessionOptions& options,
                                              std::shared_ptr<void> bench);

/// Runs Python's handlers of the signals that have come.
/// @throws py::error_already_set with what they raise, such as KeyboardInterrupt
inline void handle_signals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// Calls `call` without the interpreter lock. A signal that arrives meanwhile calls `end_wait`, and
/// `wait_again` after the call.
/// @throws py::error_already_set with what a handler of a signal raises
template <typename Call>
auto interruptible(SignalWatch::Call end_wait, SignalWatch::Call wait_again, const Call& call) {
  SignalWatch watch(std::move(end_wait), std::move(wait_again));
  handle_signals();  // one that came just before the watch began
  auto result = [&call] {
    const Unlocked unlocked;
    return call();
  }();
  watch.end();
  handle_signals();
  return result;
}

/// Calls `call(session)` without the interpreter lock; Ctrl-C interrupts the session.
/// @throws py::error_already_set when the session was closed, and with what a handler of a signal
///         raises
template <typename Call>
auto waiting(const SharedPySession& py_session, const Call& call) {
  PySession::Use begun(*py_session);
  PySession* const interrupted = py_session.get();
  return interruptible(
      [interrupted] {
        interrupted->interrupt();
      },
      [interrupted] {
        interrupted->end_interrupt();
      },
      [&] {
        // Ends before the thread asks for the interpreter lock, which may be late: see Unlocked.
        const PySession::Use use(std::move(begun));
        return call(use.session());
      });
}

/// The same, without a watch for signals where `ends_by_itself(session)`: no interrupt would end
/// the call, and the system calls of the watch take as long as a step.
/// @param ends_by_itself asked with the interpreter lock, must not wait
template <typename Ask, typename Call>
auto waiting_unless(const Ask& ends_by_itself, const SharedPySession& py_session,
                    const Call& call) {
  if (!ends_by_itself(*py_session->session())) return waiting(py_session, call);
  handle_signals();  // a loop that is not Python's own, such as deque(follower), asks nowhere else
  PySession::Use begun(*py_session);
  const Unlocked unlocked;
  const PySession::Use use(std::move(begun));  // ends first, as in waiting()
  return call(use.session());
}

/// A part of a session, such as an axis, and what keeps the session. A forked process leaves it as
/// it is.
template <typename Part>
struct PartOfSession {
  PartOfSession(Part made, SharedPySession keeper)
      : part(std::move(made)), py_session(std::move(keeper)) {}

  ~PartOfSession() {
    if (py_session && py_session->is_inherited()) leave(std::move(part));
  }

  PartOfSession(const PartOfSession&) = default;
  PartOfSession(PartOfSession&&) noexcept = default;
  PartOfSession& operator=(const PartOfSession&) = default;
  PartOfSession& operator=(PartOfSession&&) noexcept = default;

  Part part;
  SharedPySession py_session;
};

/// Runs `call(part)`, which ends with an outcome, as waiting() does.
/// @throws py::error_already_set as waiting(), and unless the outcome is ok
template <typename Part, typename Call>
void run(PartOfSession<Part>& self, const Call& call) {
  check(waiting(self.py_session, [&](client::Session& /*session*/) {
    return call(self.part);
  }));
}

/// The same for a call that gives a value. @return the value.
template <typename Part, typename Call>
auto get(PartOfSession<Part>& self, const Call& call) {
  return value_or_raise(waiting(self.py_session, [&](client::Session& /*session*/) {
    return call(self.part);
  }));
}

/// @return whether Python takes the value as true.
/// @throws py::error_already_set with what the value raises
inline bool is_true(const py::object& value) {
  const int truth = PyObject_IsTrue(value.ptr());
  if (truth < 0) throw py::error_already_set();
  return truth != 0;
}

/// An exception that Python raised in a callback: kept while C++ ends the call, raised after it.
class KeptException {
 public:
  /// Calls `call` with the interpreter lock. @return what it returns, or `otherwise` when it, or a
  /// call before, raised an exception, and while the interpreter ends.
  template <typename Value, typename Call>
  Value run(Value otherwise, const Call& call) {
    const Locked locked;
    if (!locked || exception_) return otherwise;
    try {
      return call();
    } catch (py::error_already_set& error) {
      exception_ = std::make_unique<py::error_already_set>(std::move(error));
    }
    return otherwise;
  }

  /// @throws py::error_already_set when there was one
  void raise_again() {
    if (exception_) throw py::error_already_set(std::move(*exception_));
  }

 private:
  std::unique_ptr<py::error_already_set> exception_;
};

/// Ends every open session. With the interpreter lock.
void close_all_sessions();

}  // namespace vdrive::python

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

/// An object that must not outlive its session.
class Dependent {
 public:
  Dependent() = default;
  virtual ~Dependent() = default;
  Dependent(const Dependent&) = delete;
  Dependent& operator=(const Dependent&) = delete;

  /// Ends the use of the session; waits for calls of other threads that use it. Any thread. Does
  /// nothing in a forked process.
  virtual void close() noexcept = 0;

  const Origin origin{};
};

/// A session as owned by Python: every handle keeps a reference, and close() ends it earlier.
class PySession {
 public:
  /// @param bench kept until the session has ended; null if it is not a bench of this program
  /// @throws std::runtime_error as client::Session does
  PySession(const client::SessionOptions& options, std::shared_ptr<void> bench)
      : bench_(std::move(bench)), session_(std::make_shared<client::Session>(options)) {}

  ~PySession() { close(); }

  PySession(const PySession&) = delete;
  PySession& operator=(const PySession&) = delete;

  /// A call that uses the session, and keeps it from ending. Ends on the thread that started it.
  class Use {
   public:
    /// Call with the interpreter lock.
    /// @throws py::error_already_set as session()
    explicit Use(PySession& owner);
    ~Use();
    Use(Use&&) = default;
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    Use& operator=(Use&&) = delete;

    [[nodiscard]] client::Session& session() const noexcept { return *session_; }

   private:
    PySession* owner_;
    std::shared_ptr<client::Session> session_;  ///< null if moved from
  };

  /// Call with the interpreter lock.
  /// @return the session, kept alive by the returned pointer.
  /// @throws py::error_already_set if it was closed, and in a forked process
  [[nodiscard]] std::shared_ptr<client::Session> session() const;

  /// @return whether it was closed; true also in a forked process.
  [[nodiscard]] bool is_closed() const;

  /// @return whether this process was forked from the one that opened the session.
  [[nodiscard]] bool is_inherited() const noexcept { return origin_.is_inherited(); }

  /// Closes `dependent` before the session; immediately if the session is already closed.
  void adopt(const std::shared_ptr<Dependent>& dependent);

  /// As Session::interrupt() and end_interrupt(); no effect after close(). Any thread.
  void interrupt() noexcept;
  void end_interrupt() noexcept;

  /// Ends the calls of all threads, waits for those of other threads, and ends the session. A call
  /// that does not end, because its callback does not return, ends the session later. Call without
  /// the interpreter lock. Any thread. Does nothing in a forked process.
  void close() noexcept;

  /// The bench for calls that name none. Guarded by the interpreter lock.
  std::optional<std::uint32_t> only_bench;

  /// The queues to which the session reports events and services. Guarded by the interpreter lock.
  std::weak_ptr<Dependent> event_stream;
  std::weak_ptr<Dependent> service_stream;

 private:
  const Origin origin_;
  mutable std::mutex mutex_;  ///< never ask for the interpreter lock while holding it
  std::shared_ptr<void> bench_;
  std::shared_ptr<client::Session> session_;
  std::vector<std::thread::id> callers_;  ///< the thread of each Use
  std::condition_variable has_ended_;     ///< notified when a Use has ended
  std::vector<std::weak_ptr<Dependent>> dependents_;
};

using SharedPySession = std::shared_ptr<PySession>;

/// Call without the interpreter lock, which it acquires at the end.
/// @throws as PySession does
[[nodiscard]] SharedPySession open_py_session(const client::SessionOptions& options,
                                              std::shared_ptr<void> bench);

/// Runs Python's handlers for the signals that have arrived.
/// @throws py::error_already_set with their exception, such as KeyboardInterrupt
inline void handle_signals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// Calls `call` without the interpreter lock. A signal that arrives in the meantime calls
/// `end_wait`, and `wait_again` after the call.
/// @throws py::error_already_set with the exception of a signal handler
template <typename Call>
auto interruptible(SignalWatch::Call end_wait, SignalWatch::Call wait_again, const Call& call) {
  SignalWatch watch(std::move(end_wait), std::move(wait_again));
  handle_signals();  // one that came just before the watch started
  auto result = [&call] {
    const Unlocked unlocked;
    return call();
  }();
  watch.end();
  handle_signals();
  return result;
}

/// Calls `call(session)` without the interpreter lock; Ctrl-C interrupts the session.
/// @throws py::error_already_set if the session was closed, or with the exception of a signal
///         handler
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
        // Must end before the thread asks for the interpreter lock, which may come late: see
        // Unlocked.
        const PySession::Use use(std::move(begun));
        return call(use.session());
      });
}

/// As waiting(), but without a signal watch if `ends_by_itself(session)`: an interrupt would not
/// end the call, and the system calls of the watch take as long as a step.
/// @param ends_by_itself called with the interpreter lock, must not wait
template <typename Ask, typename Call>
auto waiting_unless(const Ask& ends_by_itself, const SharedPySession& py_session,
                    const Call& call) {
  if (!ends_by_itself(*py_session->session())) return waiting(py_session, call);
  handle_signals();  // a C loop such as deque(follower) checks nowhere else
  PySession::Use begun(*py_session);
  const Unlocked unlocked;
  const PySession::Use use(std::move(begun));  // must end first, as in waiting()
  return call(use.session());
}

/// A part of a session, such as an axis, together with a reference to the session. In a forked
/// process it is not touched.
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

/// Runs `call(part)`, which returns an outcome, as waiting() does.
/// @throws py::error_already_set as waiting(), and if the outcome is not ok
template <typename Part, typename Call>
void run(PartOfSession<Part>& self, const Call& call) {
  check(waiting(self.py_session, [&](client::Session& /*session*/) {
    return call(self.part);
  }));
}

/// As run(), for a call that returns a value.
/// @return the value.
template <typename Part, typename Call>
auto get(PartOfSession<Part>& self, const Call& call) {
  return value_or_raise(waiting(self.py_session, [&](client::Session& /*session*/) {
    return call(self.part);
  }));
}

/// @return whether Python considers the value true.
/// @throws py::error_already_set with the exception of the value
inline bool is_true(const py::object& value) {
  const int truth = PyObject_IsTrue(value.ptr());
  if (truth < 0) throw py::error_already_set();
  return truth != 0;
}

/// An exception raised by Python in a callback: kept while C++ ends the call, raised again
/// afterwards.
class KeptException {
 public:
  /// Calls `call` with the interpreter lock.
  /// @return its result; `otherwise` if it or an earlier call raised an exception, and while the
  ///         interpreter is being finalised.
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

  /// @throws py::error_already_set if there was one
  void raise_again() {
    if (exception_) throw py::error_already_set(std::move(*exception_));
  }

 private:
  std::unique_ptr<py::error_already_set> exception_;
};

/// Ends every open session. Call with the interpreter lock.
void close_all_sessions();

}  // namespace vdrive::python

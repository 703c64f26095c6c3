// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "errors.hpp"
#include "fork.hpp"
#include "python.hpp"
#include "signal_watch.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
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
  /// @throws std::runtime_error as client::Session does
  explicit PySession(const client::SessionOptions& options)
      : session_(std::make_shared<client::Session>(options)) {}

  ~PySession() { close(); }

  PySession(const PySession&) = delete;
  PySession& operator=(const PySession&) = delete;

  /// @return the session, which ends no earlier than what is returned.
  /// @throws py::error_already_set when it was closed, and in a forked process
  [[nodiscard]] std::shared_ptr<client::Session> session() const;

  /// @return true also in a forked process.
  [[nodiscard]] bool is_closed() const;

  /// @return whether this process was forked from the one that opened the session.
  [[nodiscard]] bool is_inherited() const noexcept { return origin_.is_inherited(); }

  /// Closes `dependent` before the session.
  void adopt(const std::shared_ptr<Dependent>& dependent);

  /// Ends the calls that wait, and the session. Without the interpreter lock. Any thread. Does
  /// nothing in a forked process.
  void close() noexcept;

  /// The bench of calls that name none. Guarded by the interpreter lock.
  std::optional<std::uint32_t> only_bench;

  /// The queues to which the session reports events and services. Guarded by the interpreter lock.
  std::weak_ptr<Dependent> event_stream;
  std::weak_ptr<Dependent> service_stream;

 private:
  const Origin origin_;
  mutable std::mutex mutex_;
  std::shared_ptr<client::Session> session_;
  std::vector<std::weak_ptr<Dependent>> dependents_;
};

using SharedPySession = std::shared_ptr<PySession>;

/// Without the interpreter lock, which it takes at its end. @throws what PySession throws
[[nodiscard]] SharedPySession open_py_session(const client::SessionOptions& options);

/// Runs Python's handlers of the signals that have come.
/// @throws py::error_already_set with what they raise, such as KeyboardInterrupt
inline void handle_signals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// Calls `call` without the interpreter lock. A signal that arrives meanwhile calls `end_wait`.
/// @throws py::error_already_set with what a handler of a signal raises
template <typename Call>
auto interruptible(std::function<void()> end_wait, const std::function<void()>& wait_again,
                   const Call& call) {
  SignalWatch watch(std::move(end_wait));
  handle_signals();  // one that came just before the watch began
  auto result = [&call] {
    const py::gil_scoped_release unlocked;
    return call();
  }();
  if (watch.end()) wait_again();
  handle_signals();
  return result;
}

/// Calls `call(session)` without the interpreter lock; Ctrl-C interrupts the session.
/// @throws py::error_already_set when the session was closed, and with what a handler of a signal
///         raises
template <typename Call>
auto waiting(const SharedPySession& py_session, const Call& call) {
  const std::shared_ptr<client::Session> session = py_session->session();
  return interruptible(
      [session] {
        session->interrupt();
      },
      [&session] {
        session->end_interrupt();
      },
      [&] {
        return call(*session);
      });
}

/// An exception that Python raised in a callback: kept while C++ ends the call, raised after it.
class KeptException {
 public:
  /// Calls `call` with the interpreter lock. @return what it returns, or `otherwise` when it, or a
  /// call before, raised an exception.
  template <typename Value, typename Call>
  Value run(Value otherwise, const Call& call) {
    const py::gil_scoped_acquire locked;
    if (exception_) return otherwise;
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

/// Ends every open session: Python calls it at its exit.
void close_all_sessions();

}  // namespace vdrive::python

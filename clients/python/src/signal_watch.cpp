// SPDX-License-Identifier: Apache-2.0
#include "signal_watch.hpp"

#include "fork.hpp"
#include "python.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

namespace vdrive::python {
namespace {

/// @return whether the signal ends a wait; the handlers of other signals run after the wait.
bool ends_waits(char signal) {
  return signal != SIGCHLD && signal != SIGWINCH && signal != SIGCONT;
}

/// The thread that waits for signals, and the wait that it ends.
class Watcher {
 public:
  Watcher();

  [[nodiscard]] bool is_of_this_process() const noexcept { return !origin_.is_inherited(); }

  [[nodiscard]] int file() const noexcept { return ends_[1]; }

  void begin(SignalWatch::Wait& wait);

  /// Removes the innermost wait, after recording in it all signals that have arrived.
  /// @param for_outer whether the signals are passed on to the outer wait
  void end(const SignalWatch::Wait& wait, bool for_outer);

 private:
  [[noreturn]] void run();
  void read_signals();

  std::array<int, 2> ends_{-1, -1};
  const Origin origin_;
  std::mutex mutex_;
  SignalWatch::Wait* innermost_ = nullptr;
};

Watcher::Watcher() {
  if (pipe2(ends_.data(), O_CLOEXEC | O_NONBLOCK) != 0) {
    throw std::system_error(errno, std::generic_category(), "pipe for signals");
  }
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread([this] {
    run();
  }).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void Watcher::begin(SignalWatch::Wait& wait) {
  const std::scoped_lock lock(mutex_);
  wait.outer = std::exchange(innermost_, &wait);
}

void Watcher::end(const SignalWatch::Wait& wait, bool for_outer) {
  const std::scoped_lock lock(mutex_);
  read_signals();
  innermost_ = wait.outer;
  if (for_outer && innermost_ != nullptr) innermost_->signals += wait.signals;
}

/// Called with the mutex held.
void Watcher::read_signals() {
  std::array<char, 64> numbers{};
  const ssize_t count = read(ends_[0], numbers.data(), numbers.size());
  for (std::size_t i = 0; count > 0 && i < static_cast<std::size_t>(count); ++i) {
    if (innermost_ == nullptr) continue;
    innermost_->signals.push_back(numbers.at(i));
    if (!ends_waits(numbers.at(i))) continue;
    innermost_->end();
    innermost_->has_ended = true;
  }
}

void Watcher::run() {
  while (true) {
    pollfd news{ends_[0], POLLIN, 0};
    if (poll(&news, 1, -1) <= 0) continue;
    const std::scoped_lock lock(mutex_);
    read_signals();
  }
}

/// Never destroyed: its thread ends with the process. Guarded by the interpreter lock.
Watcher*& only_watcher() {
  static Watcher* only = nullptr;  // NOLINT(*-avoid-non-const-global-variables): see above
  return only;
}

/// A forked process has no thread of its parent, and creates its own.
Watcher& watcher() {
  Watcher*& only = only_watcher();
  if (only == nullptr || !only->is_of_this_process()) {
    only = new Watcher();  // NOLINT(cppcoreguidelines-owning-memory): on purpose, see above
  }
  return *only;
}

/// Calls signal.set_wakeup_fd, which the C API does not offer.
/// @return the previous file, -1 = none.
int set_wakeup_file(int file) {
  // Never destroyed: the interpreter may be gone by then.
  static const py::handle set =
      py::module_::import("signal").attr("set_wakeup_fd").cast<py::object>().release();
  static const py::handle quietly = [] {
    py::dict arguments;
    arguments["warn_on_full_buffer"] = false;
    return arguments.release();
  }();
  const py::tuple files = py::make_tuple(file);
  PyObject* const before = PyObject_Call(set.ptr(), files.ptr(), quietly.ptr());
  if (before == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::int_>(before).cast<int>();
}

/// Tries to restore the wakeup file. Preserves a pending exception.
bool restore_wakeup_file(int file) noexcept {
  try {
    const py::error_scope on_its_way;
    set_wakeup_file(file);
    return true;
  } catch (...) {
    return false;  // its owner has closed it: then no thread waits for it
  }
}

/// Properties of the calling thread. Cached, because every call needs them: without a cache, a call
/// would make eight system calls (1 us each on a virtual machine), five of them only to look up
/// these properties and the process of the watcher.
struct CallingThread {
  const Origin origin{};
  const bool is_main = gettid() == getpid();
};

bool is_main_thread() {
  thread_local std::optional<CallingThread> calling;
  // The thread that forks is the main thread of the new process.
  if (!calling || calling->origin.is_inherited()) calling.emplace();
  return calling->is_main;
}

}  // namespace

SignalWatch::SignalWatch(Call end_wait, Call wait_again)
    : wait_{.end = std::move(end_wait), .signals{}},
      wait_again_(std::move(wait_again)),
      is_on_(is_main_thread()) {
  if (!is_on_) return;
  const int own_file = watcher().file();
  outer_file_ = set_wakeup_file(own_file);
  is_inner_ = outer_file_ == own_file;
  watcher().begin(wait_);
}

SignalWatch::~SignalWatch() {
  // Only a mutex could throw. An exception of the watched call may be on its way and matters more.
  try {
    end();
  } catch (...) {  // NOLINT(bugprone-empty-catch): see above
  }
}

void SignalWatch::end() {
  if (!std::exchange(is_on_, false)) return;
  // A callback may have forked: then there is another watcher.
  if (is_inner_) outer_file_ = watcher().file();
  if (!restore_wakeup_file(outer_file_)) restore_wakeup_file(-1);
  watcher().end(wait_, is_inner_);
  if (wait_.has_ended) wait_again_();
  if (is_inner_ || outer_file_ < 0 || wait_.signals.empty()) return;
  // Passes the signals on to the previous wakeup file, such as that of the asyncio loop, to which
  // the interpreter would have written them.
  const ssize_t written = write(outer_file_, wait_.signals.data(), wait_.signals.size());
  static_cast<void>(written);
}

void forget_signals_of_parent() {
  const Watcher* const parents = only_watcher();
  if (parents == nullptr || parents->is_of_this_process()) return;
  const int file = set_wakeup_file(-1);
  if (file != parents->file()) restore_wakeup_file(file);
}

}  // namespace vdrive::python

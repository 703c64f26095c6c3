// SPDX-License-Identifier: Apache-2.0
#include "interpreter_lock.hpp"

#include "py_session.hpp"

#include <atomic>
#include <chrono>
#include <thread>
#include <type_traits>

namespace vdrive::python {
namespace {

using namespace std::chrono_literals;

// How long end_calls() waits for calls that no session can end, such as the start of a bench.
constexpr auto kPatienceAtExit = 1s;
constexpr auto kLook = 1ms;

struct Calls {
  /// Set at exit: from then on, a call within a callback still returns to Python, so that the outer
  /// call can end; an outermost call blocks.
  std::atomic<bool> end = false;
  std::atomic<bool> is_over = false;   ///< set later: no call returns to Python any more
  std::atomic<std::thread::id> ender;  ///< the thread in which the interpreter is finalised
  std::atomic<int> under_way = 0;      ///< calls in progress without the interpreter lock
  std::atomic<int> asking_for_lock = 0;
};

// Must outlive the destructors of statics: threads stay blocked in their calls until the process
// ends.
static_assert(std::is_trivially_destructible_v<Calls>);

Calls& calls() {
  static Calls only;
  return only;
}

/// The number of nested calls of this thread, each in a callback of the previous one.
int& own_calls() {
  thread_local int count = 0;
  return count;
}

[[noreturn]] void rest() {
  while (true) std::this_thread::sleep_for(1h);
}

bool is_ender() {
  return calls().ender.load() == std::this_thread::get_id();
}

/// @return whether `lock` was called. The finalisation of the interpreter either waits for it or
///         prevents it.
template <typename Lock>
bool ask_for_lock(const Lock& lock) {
  ++calls().asking_for_lock;
  const bool may_ask = !calls().is_over || is_ender();
  if (may_ask) lock();
  --calls().asking_for_lock;
  return may_ask;
}

/// @return the state needed to reacquire the lock.
PyThreadState* begin_call() {
  stop_late_thread();
  ++calls().under_way;
  ++own_calls();
  return PyEval_SaveThread();
}

}  // namespace

bool is_late() noexcept {
  return calls().end && !is_ender();
}

void stop_late_thread() {
  // A call within a callback fails, so that the outer one ends and releases what it holds.
  if (!is_late() || own_calls() > 0) return;
  PyEval_SaveThread();
  rest();
}

Unlocked::Unlocked() : state_(begin_call()) {}

Unlocked::~Unlocked() {
  --own_calls();
  --calls().under_way;
  if (is_late() && own_calls() == 0) rest();
  const bool is_back = ask_for_lock([this] {
    PyEval_RestoreThread(state_);
  });
  if (!is_back) rest();
  stop_late_thread();  // finalisation has started in the meantime
}

Locked::Locked() {
  if (is_late()) return;  // do not start a callback any more
  ask_for_lock([this] {
    lock_.emplace();
  });
}

void end_calls() {
  Calls& all = calls();
  all.ender = std::this_thread::get_id();
  all.end = true;
  close_all_sessions();
  const py::gil_scoped_release unlocked;
  const auto end = std::chrono::steady_clock::now() + kPatienceAtExit;
  while (all.under_way > own_calls() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(kLook);
  }
  all.is_over = true;
  while (all.asking_for_lock > 0) std::this_thread::sleep_for(kLook);
}

void forget_calls_of_parent() noexcept {
  calls().under_way = own_calls();
  calls().asking_for_lock = 0;
}

}  // namespace vdrive::python

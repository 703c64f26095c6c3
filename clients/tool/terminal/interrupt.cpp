// SPDX-License-Identifier: Apache-2.0
#include "terminal/interrupt.hpp"

#include <unistd.h>

#include <chrono>
#include <utility>

namespace vdrive::tool {
namespace {

constexpr int kInterrupted = 130;

// When a terminal is closed, both the shell and the kernel signal this program; `timeout` signals
// it and, again, its process group. Signals within this time therefore count as one, not as a
// second one that ends the program immediately.
constexpr std::chrono::milliseconds kRepeatedSignalTime{200};

bool is_ignored(int signal) {
  struct sigaction action {};

  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

}  // namespace

Interrupt::Interrupt() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  if (!is_ignored(SIGHUP)) sigaddset(&signals_, SIGHUP);
  sigaddset(&signals_, SIGUSR1);  // ends our own wait
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  (void)std::signal(SIGPIPE, SIG_IGN);
  thread_ = std::jthread([this](const std::stop_token& stop) {
    wait(stop);
  });
}

Interrupt::~Interrupt() {
  thread_.request_stop();
  pthread_kill(thread_.native_handle(), SIGUSR1);
  thread_.join();
}

void Interrupt::arm(std::function<void()> action) {
  const std::scoped_lock lock(mutex_);
  action_ = std::move(action);
  if (happened_ && action_) action_();
}

void Interrupt::before_exit(std::function<void()> action) {
  const std::scoped_lock lock(mutex_);
  last_action_ = std::move(action);
}

void Interrupt::disarm() {
  const std::scoped_lock lock(mutex_);
  action_ = nullptr;
}

void Interrupt::wait(const std::stop_token& stop) {
  int signal = 0;
  while (sigwait(&signals_, &signal) == 0 && !stop.stop_requested()) {
    if (signal != SIGUSR1) note(signal);
  }
}

void Interrupt::note(int signal) {
  const std::scoped_lock lock(mutex_);
  if (signal == SIGTERM || signal == SIGHUP) is_termination_ = true;
  const auto now = std::chrono::steady_clock::now();
  if (!happened_.exchange(true)) {
    first_ = now;
    if (action_) action_();
    return;
  }
  // With a closed terminal there is no impatient user.
  if (signal == SIGHUP || now - first_ < kRepeatedSignalTime) return;
  if (last_action_) last_action_();
  _exit(kInterrupted);
}

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
#include "tool/pseudo_terminal.hpp"

#include "support/deadline.hpp"
#include "support/signals.hpp"
#include "tool/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace vdrive::test {
namespace {

constexpr std::chrono::seconds kPatience{60};
constexpr int kPollTime = 100;  // [ms]

winsize size_of(std::size_t rows, std::size_t columns) {
  winsize size{};
  size.ws_row = static_cast<unsigned short>(rows);
  size.ws_col = static_cast<unsigned short>(columns);
  return size;
}

}  // namespace

PseudoTerminal::PseudoTerminal(std::size_t rows, std::size_t columns, const std::string& words,
                               const std::vector<std::string>& environment)
    : screen_(rows, columns) {
  std::vector<std::string> arguments = tool_arguments(words);
  arguments.insert(arguments.begin(), VDRIVE_TOOL);
  std::vector<char*> values;
  for (std::string& argument : arguments) values.push_back(argument.data());
  values.push_back(nullptr);
  std::vector<std::string> variables{"TERM=xterm"};
  variables.insert(variables.end(), environment.begin(), environment.end());
  const winsize size = size_of(rows, columns);
  child_ = forkpty(&terminal_, nullptr, nullptr, &size);
  if (child_ < 0) throw std::runtime_error("no pseudo terminal");
  if (child_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    unsetenv("NO_COLOR");                                             // NOLINT(*-mt-unsafe)
    for (std::string& variable : variables) putenv(variable.data());  // NOLINT(*-mt-unsafe)
    execv(VDRIVE_TOOL, values.data());
    _exit(127);
  }
  fcntl(terminal_, F_SETFD, FD_CLOEXEC);  // NOLINT(*-vararg)
}

PseudoTerminal::~PseudoTerminal() {
  if (child_ > 0) {
    send_signal(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  close(terminal_);
}

/// @return false once the program has ended.
bool PseudoTerminal::read_some() {
  pollfd ready{terminal_, POLLIN, 0};
  if (poll(&ready, 1, kPollTime) == 0) return true;
  std::array<char, 4096> block{};
  const ssize_t count = read(terminal_, block.data(), block.size());
  if (count <= 0) return false;
  const std::string_view bytes(block.data(), static_cast<std::size_t>(count));
  output_ += bytes;
  screen_.take(bytes);
  return true;
}

bool PseudoTerminal::wait_until(const std::function<bool(const Screen&)>& is_wanted) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!is_wanted(screen_)) {
    if (!read_some()) return false;
    if (std::chrono::steady_clock::now() > deadline) {
      report_missed_deadline("the screen did not show it", kPatience);
      return false;
    }
  }
  return true;
}

void PseudoTerminal::resize(std::size_t rows, std::size_t columns) {
  const winsize size = size_of(rows, columns);
  ioctl(terminal_, TIOCSWINSZ, &size);  // NOLINT(*-vararg)
  screen_.resize(rows, columns);
}

void PseudoTerminal::type(const std::string& text) {
  if (write(terminal_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    throw std::runtime_error("keys not taken");
  }
}

void PseudoTerminal::interrupt() {
  type("\x03");
}

int PseudoTerminal::wait() {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (read_some()) {
    if (std::chrono::steady_clock::now() > deadline) send_signal(child_, SIGKILL);
  }
  int status = 0;
  waitpid(std::exchange(child_, 0), &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace vdrive::test

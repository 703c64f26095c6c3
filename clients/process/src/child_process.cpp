// SPDX-License-Identifier: Apache-2.0
#include "child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

// Missing from the header of glibc 2.36.
extern "C" {
#include <sys/pidfd.h>
}

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <system_error>

namespace vdrive::process {
namespace {

/// The arguments of exec. Created before the fork, because the child must not allocate after it.
std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::string_view variable_name(std::string_view variable) {
  return variable.substr(0, variable.find('='));
}

/// @return the environment of this process, with `changes` replacing variables of the same name.
std::vector<std::string> environment_with(std::vector<std::string> changes) {
  const std::size_t added = changes.size();
  for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable) {
    bool is_replaced = false;
    for (std::size_t i = 0; i < added; ++i) {
      is_replaced = is_replaced || variable_name(changes[i]) == variable_name(*variable);
    }
    if (!is_replaced) changes.emplace_back(*variable);
  }
  std::erase_if(changes, [](const std::string& variable) {
    return variable.find('=') == std::string::npos;
  });
  return changes;
}

int checked(int result, const char* what) {
  if (result >= 0) return result;
  throw std::system_error(errno, std::generic_category(), what);
}

/// Waits until the process of `handle` has ended.
/// @return false if it has not ended after `patience`.
bool has_ended_within(int handle, std::chrono::milliseconds patience) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point deadline = Clock::now() + patience;
  pollfd ended{handle, POLLIN, 0};
  while (true) {
    const auto rest = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    const int ready = poll(&ended, 1, static_cast<int>(std::max<std::int64_t>(rest.count(), 0)));
    // A signal to this process, such as Ctrl-C, does not mean that the other one has ended.
    if (ready >= 0 || errno != EINTR) return ready != 0;
  }
}

/// The descriptors for the child, as numbered in this process.
struct Streams {
  int input;
  int output;
  int errors;
  bool are_shared;
};

/// Runs in the child.
/// @return whether the descriptor is now available under this number.
bool give(int descriptor, int number) {
  // dup2 onto the same number would leave close-on-exec set.
  return descriptor == number ? fcntl(number, F_SETFD, 0) == 0  // NOLINT(*-vararg)
                              : dup2(descriptor, number) >= 0;
}

/// Runs in the child.
bool give_all(const Streams& streams) {
  // Input first: its descriptor may have the number of another stream, which would overwrite it.
  if (!give(streams.input, STDIN_FILENO)) return false;
  if (streams.are_shared) return give(streams.output, kChildResults);
  return give(streams.output, STDOUT_FILENO) && give(streams.errors, STDERR_FILENO);
}

/// Runs in the child, between fork and exec: system calls only.
[[noreturn]] void become(const std::vector<char*>& command, const std::vector<char*>& environment,
                         const Streams& streams, pid_t parent) {
  constexpr int kCannotStart = 127;
  sigset_t none;
  sigemptyset(&none);
  // NOLINTNEXTLINE(concurrency-mt-unsafe): the child has only one thread
  sigprocmask(SIG_SETMASK, &none, nullptr);
  (void)std::signal(SIGPIPE, SIG_DFL);
  // A terminal may stop a process that writes to it from another process group.
  if (streams.are_shared) (void)std::signal(SIGTTOU, SIG_IGN);
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(kCannotStart);  // the parent ended before the line above
  if (!give_all(streams)) _exit(kCannotStart);
  execve(command.front(), command.data(), environment.data());
  _exit(kCannotStart);
}

/// @return an in-memory file with this text, positioned at its beginning.
int file_of(const std::string& text) {
  const int file = checked(memfd_create("input", MFD_CLOEXEC), "memfd_create");
  for (std::size_t written = 0; written < text.size();) {
    const std::string_view rest = std::string_view(text).substr(written);
    const ssize_t count = pwrite(file, rest.data(), rest.size(), static_cast<off_t>(written));
    if (count <= 0) {
      const int error = errno;
      close(file);
      throw std::system_error(error, std::generic_category(), "input of a program");
    }
    written += static_cast<std::size_t>(count);
  }
  return file;
}

pid_t start(std::vector<std::string> command, std::vector<std::string> changes,
            const Streams& streams) {
  std::vector<std::string> environment = environment_with(std::move(changes));
  const std::vector<char*> arguments = pointers_to(command);
  const std::vector<char*> variables = pointers_to(environment);
  const pid_t parent = getpid();
  const pid_t child = checked(fork(), "fork");
  if (child == 0) become(arguments, variables, streams, parent);
  return child;
}

/// @return a handle of the child. If there is none, nothing could end the child later, so it is
///         killed.
int handle_of(pid_t child) {
  const int handle = pidfd_open(child, 0);
  if (handle >= 0) return handle;
  const int error = errno;
  (void)kill(child, SIGKILL);  // not waited for yet, so the number still belongs to the child
  while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  throw std::system_error(error, std::generic_category(), "pidfd_open");
}

std::string content_of(int file) {
  std::string text;
  std::array<char, 4096> block{};
  while (true) {
    const ssize_t count = pread(file, block.data(), block.size(), static_cast<off_t>(text.size()));
    if (count <= 0) return text;
    text.append(block.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) close(number_);
}

ChildProcess::ChildProcess(std::vector<std::string> command, std::vector<std::string> environment,
                           const ChildStreams& streams)
    : output_(checked(memfd_create("output", MFD_CLOEXEC), "memfd_create")),
      errors_(checked(memfd_create("errors", MFD_CLOEXEC), "memfd_create")),
      id_(start(std::move(command), std::move(environment),
                {.input = Descriptor(file_of(streams.input)).get(),
                 .output = output_.get(),
                 .errors = errors_.get(),
                 .are_shared = streams.are_shared})),
      handle_(handle_of(id_)) {}

ChildProcess::~ChildProcess() {
  send(SIGKILL);
  static_cast<void>(wait());
}

void ChildProcess::send(int signal) const noexcept {
  // Unlike the number, the handle can never refer to another process.
  (void)pidfd_send_signal(handle_.get(), signal, nullptr, 0);
}

std::optional<int> ChildProcess::wait(std::optional<std::chrono::milliseconds> patience) {
  if (code_) return code_;
  if (patience && !has_ended_within(handle_.get(), *patience)) return std::nullopt;
  int status = 0;
  while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
  }
  code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  return code_;
}

void ChildProcess::stop(std::chrono::milliseconds patience) {
  send(SIGTERM);
  if (wait(patience)) return;
  send(SIGKILL);
  static_cast<void>(wait());
}

std::string ChildProcess::output() const {
  return content_of(output_.get());
}

std::string ChildProcess::errors() const {
  return content_of(errors_.get());
}

}  // namespace vdrive::process

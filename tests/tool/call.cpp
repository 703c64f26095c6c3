// SPDX-License-Identifier: Apache-2.0
#include "tool/call.hpp"

#include "support/bench_on_wire.hpp"
#include "tool.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <stdexcept>

namespace vdrive::test {
namespace {

/// Redirects a standard stream to a file in memory for the lifetime of the object.
class StreamInMemory {
 public:
  StreamInMemory(int stream, const std::string& content)
      : stream_(stream), former_(dup(stream)), memory_(memfd_create("stream", MFD_CLOEXEC)) {
    const bool is_written =
        pwrite(memory_, content.data(), content.size(), 0) == static_cast<ssize_t>(content.size());
    if (former_ < 0 || !is_written || dup2(memory_, stream) != stream) {
      throw std::runtime_error("no file in memory for stream " + std::to_string(stream));
    }
  }

  ~StreamInMemory() {
    dup2(former_, stream_);
    close(former_);
    close(memory_);
  }

  StreamInMemory(const StreamInMemory&) = delete;
  StreamInMemory& operator=(const StreamInMemory&) = delete;

  [[nodiscard]] std::string content() const {
    std::string text(static_cast<std::size_t>(lseek(memory_, 0, SEEK_END)), '\0');
    if (pread(memory_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) {
      throw std::runtime_error("stream " + std::to_string(stream_) + " cannot be read");
    }
    return text;
  }

 private:
  int stream_;
  int former_;
  int memory_;
};

/// Standard input from memory. An end of file that was reached earlier is forgotten.
class InputInMemory {
 public:
  explicit InputInMemory(const std::string& content) : stream_(STDIN_FILENO, content) { rewind(); }

  ~InputInMemory() { rewind(); }

  InputInMemory(const InputInMemory&) = delete;
  InputInMemory& operator=(const InputInMemory&) = delete;

 private:
  static void rewind() {
    (void)std::fflush(stdin);  // drops the read-ahead
    std::clearerr(stdin);
    std::cin.clear();
  }

  StreamInMemory stream_;
};

/// Restores the signal mask: called in this process, the tool also blocks signals for the tests.
class SignalsKept {
 public:
  SignalsKept() { pthread_sigmask(SIG_BLOCK, nullptr, &mask_); }

  ~SignalsKept() { pthread_sigmask(SIG_SETMASK, &mask_, nullptr); }

  SignalsKept(const SignalsKept&) = delete;
  SignalsKept& operator=(const SignalsKept&) = delete;

 private:
  sigset_t mask_{};
};

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace

Finished captured(const std::function<int()>& work, const std::string& input) {
  const auto begin = std::chrono::steady_clock::now();
  const SignalsKept signals;
  (void)std::fflush(stdout);
  const InputInMemory in(input);
  const StreamInMemory out(STDOUT_FILENO, "");
  const StreamInMemory errors(STDERR_FILENO, "");
  Finished finished;
  finished.code = work();
  finished.output = out.content();
  finished.errors = errors.content();
  finished.duration = std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::steady_clock::now() - begin);
  return finished;
}

Finished call(const std::string& words, const std::string& input) {
  return call(words_of(words), input);
}

Finished call(std::vector<std::string> arguments, const std::string& input) {
  if (runs_over_dds()) return tool(std::move(arguments), input);
  return captured(
      [&arguments] {
        return static_cast<int>(tool::run_tool(std::move(arguments), local_bus()));
      },
      input);
}

}  // namespace vdrive::test

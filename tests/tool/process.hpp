// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <string>
#include <vector>

namespace vdrive::test {

/// The result of a program.
struct Finished {
  int code = 0;  ///< exit code, or -signal
  std::string output;
  std::string errors;
  std::chrono::milliseconds duration{};

  /// @return the lines of the output.
  [[nodiscard]] std::vector<std::string> lines() const;
};

/// A running program, its output in pipes; killed by the destructor unless it has ended.
class Process {
 public:
  /// @param arguments without the program
  /// @param input what it reads on standard input
  Process(const std::string& program, std::vector<std::string> arguments,
          const std::string& input = "");
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) const;

  [[nodiscard]] pid_t id() const noexcept { return child_; }

  /// Reads a line of its output. @return an empty string at the end.
  std::string read_line();

  /// Reads a line of its errors. @return an empty string at the end.
  std::string read_error_line();

  /// Closes our end of its output: its writes fail.
  void stop_reading();

  /// Waits for the end, at most 120 s, then kills it.
  Finished wait();

 private:
  std::string program_;
  pid_t child_ = 0;
  int output_ = -1;
  int errors_ = -1;
  std::string read_ahead_;
  std::string errors_ahead_;
  std::chrono::steady_clock::time_point start_;
};

/// Runs the tool on the domain of this test. @param words the command line, split at blanks
[[nodiscard]] Finished tool(const std::string& words, const std::string& input = "");

/// Runs the tool with arguments as they are, on the domain of this test.
[[nodiscard]] Finished tool(std::vector<std::string> arguments, const std::string& input = "");

/// @return a tool that runs on the domain of this test until it ends.
[[nodiscard]] std::vector<std::string> tool_arguments(const std::string& words);

/// A service of this build on the domain of this test, available after construction.
class RunningService {
 public:
  /// @param words command line beside the domain, such as "--clock lockstep"; it logs nothing
  ///        unless they name a --log-level, and then no more than a pipe holds
  explicit RunningService(const std::string& words);
  ~RunningService();
  RunningService(const RunningService&) = delete;
  RunningService& operator=(const RunningService&) = delete;

  [[nodiscard]] pid_t id() const noexcept { return process_.id(); }

  /// Ends it as a user would.
  Finished stop();

  /// Kills it.
  void kill();

  /// Pauses its process, and continues it.
  void freeze() const { process_.send(SIGSTOP); }

  void thaw() const { process_.send(SIGCONT); }

 private:
  Process process_;
};

}  // namespace vdrive::test

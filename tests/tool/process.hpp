// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <string>
#include <vector>

namespace vdrive::test {

/// The outcome of a program.
struct Finished {
  int code = 0;  ///< exit code, or -signal
  std::string output;
  std::string errors;
  std::chrono::milliseconds duration{};

  /// @return the lines of the output.
  [[nodiscard]] std::vector<std::string> lines() const;
};

/// A running program whose output is read through pipes. The destructor kills it if it is still
/// running.
class Process {
 public:
  /// @param arguments without the program
  /// @param input its standard input
  Process(const std::string& program, std::vector<std::string> arguments,
          const std::string& input = "");
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) const;

  [[nodiscard]] pid_t id() const noexcept { return child_; }

  /// Reads a line of its output.
  /// @return an empty string at the end.
  std::string read_line();

  /// Reads a line of its standard error.
  /// @return an empty string at the end.
  std::string read_error_line();

  /// Closes the reading end of its output, so that its writes fail.
  void stop_reading();

  /// Waits for the end; kills the program after 120 s without output.
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

/// Runs the tool on the domain of this test.
/// @param words the command line, split at spaces
[[nodiscard]] Finished tool(const std::string& words, const std::string& input = "");

/// The same with arguments that are not split.
[[nodiscard]] Finished tool(std::vector<std::string> arguments, const std::string& input = "");

/// @return arguments of the tool for the domain of this test.
[[nodiscard]] std::vector<std::string> tool_arguments(const std::string& words);

/// A service of this build on the domain of this test. Its bench is available after construction.
class RunningService {
 public:
  /// @param words command line without the domain, such as "--clock lockstep". Without --log-level
  ///         it logs nothing; otherwise it must not log more than a pipe holds.
  explicit RunningService(const std::string& words);
  ~RunningService();
  RunningService(const RunningService&) = delete;
  RunningService& operator=(const RunningService&) = delete;

  [[nodiscard]] pid_t id() const noexcept { return process_.id(); }

  /// Ends it as a user would, with SIGTERM.
  Finished stop();

  /// Kills it.
  void kill();

  /// Pause and resume its process.
  void freeze() const { process_.send(SIGSTOP); }

  void thaw() const { process_.send(SIGCONT); }

 private:
  Process process_;
};

}  // namespace vdrive::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/origin.hpp"

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::process {

// Fork protection, made available to clients that do not use the wire directly.
using wire::made_here;
using wire::Origin;

/// A file descriptor, closed with this object.
class Descriptor {
 public:
  explicit Descriptor(int number) noexcept : number_(number) {}

  ~Descriptor();
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  [[nodiscard]] int get() const noexcept { return number_; }

 private:
  int number_;
};

/// The standard input and the output mode of a child.
struct ChildStreams {
  std::string input{};      ///< text on standard input
  bool are_shared = false;  ///< it inherits the output streams of this program
};

/// The descriptor to which a child with shared streams writes the text that output() returns.
constexpr int kChildResults = 3;

/// A program started by this one. It receives SIGTERM when the thread that started it ends, so that
/// a killed tool leaves nothing behind. It has its own process group: Ctrl-C reaches it only
/// through send(). Its output is kept in memory unless the streams are shared.
class ChildProcess {
 public:
  /// @param command the program's path, then its arguments
  /// @param environment changes to the environment of this process: NAME=VALUE, or NAME to remove a
  ///        variable
  /// @throws std::system_error
  ChildProcess(std::vector<std::string> command, std::vector<std::string> environment = {},
               const ChildStreams& streams = {});

  /// Kills it if it is still running.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Sends a signal; does nothing after the program has ended. Any thread.
  void send(int signal) const noexcept;

  /// @return the exit code, or -signal; nothing if it is still running after `patience`.
  std::optional<int> wait(std::optional<std::chrono::milliseconds> patience = std::nullopt);

  /// Sends SIGTERM, and SIGKILL if it has not ended after `patience`.
  void stop(std::chrono::milliseconds patience);

  /// @return a descriptor that becomes readable when the program has ended.
  [[nodiscard]] int descriptor() const noexcept { return handle_.get(); }

  /// The output so far; with shared streams, the text written to kChildResults, and no errors.
  [[nodiscard]] std::string output() const;
  [[nodiscard]] std::string errors() const;

 private:
  Descriptor output_;
  Descriptor errors_;
  pid_t id_;
  Descriptor handle_;
  std::optional<int> code_;
};

}  // namespace vdrive::process

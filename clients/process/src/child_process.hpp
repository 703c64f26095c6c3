// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/origin.hpp"

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::process {

// What a forked process may not touch, for clients that name no wire.
using wire::made_here;
using wire::Origin;

/// A descriptor, closed with this object.
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

/// What a child reads, and where it writes.
struct ChildStreams {
  std::string input{};      ///< what it reads on standard input
  bool are_shared = false;  ///< it writes where this program does
};

/// Where a child with shared streams writes what output() has.
constexpr int kChildResults = 3;

/// A program that this one has started. It receives SIGTERM when the thread that started it ends,
/// so that a killed tool leaves nothing behind. It is in a process group of its own: Ctrl-C reaches
/// it through send() only. Its output is kept in memory unless it is shared.
class ChildProcess {
 public:
  /// @param command the program's path, then its arguments
  /// @param environment changes of that of this process: NAME=VALUE, or NAME for a variable that
  /// goes
  /// @throws std::system_error
  ChildProcess(std::vector<std::string> command, std::vector<std::string> environment = {},
               const ChildStreams& streams = {});

  /// Kills it, if it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Also after its end. Any thread.
  void send(int signal) const noexcept;

  /// @return the exit code, or -signal; nothing while it still runs after `patience`.
  std::optional<int> wait(std::optional<std::chrono::milliseconds> patience = std::nullopt);

  /// SIGTERM, and SIGKILL when it has not ended after `patience`.
  void stop(std::chrono::milliseconds patience);

  /// Readable once the program has ended.
  [[nodiscard]] int descriptor() const noexcept { return handle_.get(); }

  /// What it has written so far; with shared streams no errors, and what it wrote to kChildResults.
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/deadline.hpp"
#include "support/signals.hpp"

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <thread>

namespace vdrive::test {

/// Processes, as /proc shows them.

/// @return the content of a file; empty if it cannot be read.
inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// @return a child of `parent`, or 0.
inline pid_t child_of(pid_t parent) {
  if (parent <= 1) return 0;  // 0 is no process, and 1 adopts orphans
  const std::string wanted = "PPid:\t" + std::to_string(parent) + "\n";
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    if (text_of(entry.path() / "status").find(wanted) != std::string::npos) {
      return std::stoi(entry.path().filename().string());
    }
  }
  return 0;
}

/// @return the wire process of a service; 0 if it has none.
inline pid_t wire_of(pid_t service) {
  const pid_t spawner = child_of(service);
  return spawner == 0 ? 0 : child_of(spawner);
}

/// @throws std::invalid_argument for 0 and 1, see send_signal
inline bool exists(pid_t process) {
  return send_signal(process, 0);
}

/// @return the files of /dev/shm that a service or its wire has mapped. Other files there belong to
///         other programs, such as a browser, and may appear and disappear.
inline std::set<std::string> shared_memory_of(pid_t service) {
  std::set<std::string> files;
  for (const pid_t process : {service, wire_of(service)}) {
    std::istringstream maps(text_of("/proc/" + std::to_string(process) + "/maps"));
    for (std::string line; std::getline(maps, line);) {
      if (const auto at = line.find("/dev/shm/"); at != std::string::npos) {
        files.insert(line.substr(at, line.find(' ', at) - at));
      }
    }
  }
  return files;
}

/// Repeats the check until it is true. @return false after 40 s.
template <typename Condition>
bool holds_soon(Condition condition) {
  constexpr std::chrono::seconds kPatience{40};
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) {
      report_missed_deadline("the condition did not hold", kPatience);
      return false;
    }
    std::this_thread::yield();
  }
  return true;
}

}  // namespace vdrive::test

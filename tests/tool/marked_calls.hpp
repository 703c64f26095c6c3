// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/process_tree.hpp"
#include "support/temporary_directory.hpp"
#include "tool/process.hpp"

#include <gtest/gtest.h>

#include <sys/types.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::test {

/// Calls of the tool with separate files. An environment variable marks the processes of a
/// call, including those it starts.
class MarkedCalls : public testing::Test {
 protected:
  MarkedCalls() {
    setenv("VDRIVE_TEST_MARK", mark_.c_str(), 1);  // NOLINT(concurrency-mt-unsafe): one thread
  }

  ~MarkedCalls() override {
    unsetenv("VDRIVE_TEST_MARK");  // NOLINT(concurrency-mt-unsafe): one thread
  }

  std::string file(const std::string& name, const std::string& lines) {
    const std::string path = directory_.path() / name;
    std::ofstream(path) << lines;
    return path;
  }

  [[nodiscard]] std::string report() const { return directory_.path() / "out.xml"; }

  [[nodiscard]] static Process start(const std::string& command,
                                     std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), command);
    return {VDRIVE_TOOL, std::move(arguments)};
  }

  /// @return a marked process whose command line contains all these words.
  [[nodiscard]] std::optional<pid_t> process_with(const std::vector<std::string>& words) const {
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      if (text_of(entry.path() / "environ").find(mark_) == std::string::npos) continue;
      const std::string line = text_of(entry.path() / "cmdline");
      bool has_all = true;
      for (const std::string& word : words) {
        has_all = has_all && line.find(word) != std::string::npos;
      }
      if (has_all) return static_cast<pid_t>(std::stol(entry.path().filename()));
    }
    return std::nullopt;
  }

  /// @return the process once it exists; std::nullopt after a deadline.
  [[nodiscard]] std::optional<pid_t> wait_for_process(const std::vector<std::string>& words) const {
    std::optional<pid_t> found;
    static_cast<void>(holds_soon([&] {
      found = process_with(words);
      return found.has_value();
    }));
    return found;
  }

  /// @return whether all processes of the call end soon.
  [[nodiscard]] bool all_have_ended() const {
    return holds_soon([this] {
      return !process_with({});
    });
  }

 private:
  const std::string mark_ = "vdrive-mark-" + std::to_string(getpid());
  TemporaryDirectory directory_;
};

}  // namespace vdrive::test

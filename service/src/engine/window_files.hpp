// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/window.hpp"
#include "configuration/configuration.hpp"
#include "journal/black_box.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace vdrive::service {

/// The windows of a black box in files of the state directory, `bench-N.window-NUMBER`, so that
/// they outlast the service: a window is written when it is opened, one tick after its cause, and
/// again when it is complete. Reads and writes block: not for the thread that ticks.
class WindowFiles {
 public:
  /// @param directory that exists; files of another configuration of the axes are left out
  WindowFiles(std::filesystem::path directory, const Configuration& configuration);

  /// Before the first step: gives the box what earlier runs have kept, and asks it to hand over.
  void load(BlackBox& box);

  /// Writes what the box hands over, and removes what makes room for it. A failure is logged.
  void save(BlackBox& box);

 private:
  [[nodiscard]] std::filesystem::path file(std::uint64_t number) const;
  [[nodiscard]] bool load(const std::filesystem::path& path, BlackBox& box);
  void write(const BlackBox& box, const Window& window);

  std::filesystem::path directory_;
  std::string prefix_;  ///< of the names of the files
  std::size_t axis_count_;
  std::uint64_t axes_;        ///< stands for their configuration and the layout of the state
  std::vector<Window> kept_;  ///< by number
};

}  // namespace vdrive::service

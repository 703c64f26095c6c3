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

/// Keeps the windows of a black box in files of the state directory, `bench-N.window-NUMBER`, so
/// that they outlast the service. A window is written when it is opened, one tick after its cause,
/// and again when it is complete. Reads and writes block, so the tick thread must not use this
/// class.
class WindowFiles {
 public:
  /// @param directory an existing directory; files of other axis configurations are removed
  WindowFiles(std::filesystem::path directory, const Configuration& configuration);

  /// Gives the box the windows of earlier runs, and asks it to hand over new ones. Only before the
  /// first step.
  void load(BlackBox& box);

  /// Writes the windows that the box hands over, and removes old ones to make room. Failures are
  /// logged.
  void save(BlackBox& box);

 private:
  [[nodiscard]] std::filesystem::path file(std::uint64_t number) const;
  [[nodiscard]] bool load(const std::filesystem::path& path, BlackBox& box);
  void write(const BlackBox& box, const Window& window);

  std::filesystem::path directory_;
  std::string prefix_;  ///< of the file names
  std::size_t axis_count_;
  std::uint64_t axes_;        ///< hash of their configuration and the state layout
  std::vector<Window> kept_;  ///< by number
};

}  // namespace vdrive::service

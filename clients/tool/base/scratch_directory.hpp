// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::tool {

/// A temporary directory of this run of the tool, removed by the destructor.
class ScratchDirectory {
 public:
  /// @throws std::runtime_error when it cannot be created
  ScratchDirectory();
  ~ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;

  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace vdrive::tool

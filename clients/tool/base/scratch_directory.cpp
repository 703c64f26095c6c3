// SPDX-License-Identifier: Apache-2.0
#include "base/scratch_directory.hpp"

#include "vdrive/text.hpp"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace vdrive::tool {

ScratchDirectory::ScratchDirectory() {
  std::error_code error;
  const auto parent = std::filesystem::temp_directory_path(error);
  // mkdtemp replaces the six X characters.
  path_ = (error ? std::filesystem::path("/tmp") : parent) / "vdrive-XXXXXX";
  if (::mkdtemp(path_.data()) == nullptr) {
    throw std::runtime_error("cannot make the directory " + in_quotes(path_) + ": " +
                             std::generic_category().message(errno));
  }
}

ScratchDirectory::~ScratchDirectory() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
}

}  // namespace vdrive::tool

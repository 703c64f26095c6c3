// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/program_version.hpp"

#include "vdrive/wire/library_version.hpp"

namespace vdrive::wire {

std::string program_version(const std::string& program) {
  return program + " " VDRIVE_VERSION " (" VDRIVE_COMMIT ", " + library_version() + ")";
}

}  // namespace vdrive::wire

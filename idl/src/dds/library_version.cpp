// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/library_version.hpp"

#include "dds/library/library.hpp"

namespace vdrive::wire {

std::string library_version() {
  return std::string("Fast DDS ") + kLibraryVersion;
}

}  // namespace vdrive::wire

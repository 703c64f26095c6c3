// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/library_version.hpp"

#include <fastrtps/config.h>

namespace vdrive::wire {

std::string library_version() {
  return "Fast DDS " FASTRTPS_VERSION_STR;
}

}  // namespace vdrive::wire

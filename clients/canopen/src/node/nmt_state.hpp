// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::canopen {

/// NMT states (CiA 301, 7.3.2.2), by the number that a heartbeat carries.
enum class NmtState : std::uint8_t {
  boot_up = 0x00,
  stopped = 0x04,
  operational = 0x05,
  pre_operational = 0x7F,
};

}  // namespace vdrive::canopen

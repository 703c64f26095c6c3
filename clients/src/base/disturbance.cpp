// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/disturbance.hpp"

#include "vdrive/number_text.hpp"

namespace vdrive::client {

std::string text_of(const DisturbanceRow& row) {
  if (row.fault == ErrorCode::none) return "no fault: " + std::string(row.effect);
  return "fault " + hex(static_cast<std::uint64_t>(row.fault), 4).substr(2) + "h, " +
         std::string(vdrive::describe(row.fault)) + ": " + std::string(row.effect);
}

}  // namespace vdrive::client

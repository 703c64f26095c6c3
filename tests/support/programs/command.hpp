// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"
#include "vdrive/number_text.hpp"

#include <cstdint>
#include <string>

namespace vdrive::test {

/// A controlword, a mode, a set-point, a setting or a disturbance: each is a value for an object of
/// an axis.
struct Write {
  ObjectAddress object;
  std::int64_t value;
};

/// @return the call that does it, in Python: "write((0x6060, 0), 1)".
[[nodiscard]] inline std::string to_string(const Write& write) {
  return "write((" + hex(write.object.index, 4) + ", " + std::to_string(write.object.subindex) +
         "), " + std::to_string(write.value) + ")";
}

}  // namespace vdrive::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/dictionary.hpp"

#include <cstdint>

namespace vdrive::test {

/// A controlword, a mode, a set-point or a setting: each is a value for an object of an axis.
struct Write {
  ObjectAddress object;
  std::int64_t value;
};

}  // namespace vdrive::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace vdrive::tool {

/// What the user typed cannot be understood; the message names the text and what is expected.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace vdrive::tool

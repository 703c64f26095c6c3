// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace vdrive::settings {

/// A configuration cannot be used. The message names file, line, key, value, unit and limit where
/// they apply.
class ConfigurationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace vdrive::settings

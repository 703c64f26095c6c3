// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cerrno>
#include <string>
#include <system_error>

namespace vdrive::service {

/// @throws std::system_error with the error in errno
/// @param what the failed call, such as "open /var/lib/vdrive"
[[noreturn]] inline void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::test {

/// @return a DDS domain that no other program on this machine uses. It stays reserved for the life
///         of this process, like that of a private bench. Child processes of a test share it.
[[nodiscard]] std::uint32_t test_domain();

}  // namespace vdrive::test

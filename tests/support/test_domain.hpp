// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::test {

/// @return a DDS domain that no other program on this machine uses now, as private benches have
///         one, for the life of this process. Children started by a test share it.
[[nodiscard]] std::uint32_t test_domain();

}  // namespace vdrive::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace vdrive::wire {

/// Participant that a message came from (RTPS GUID prefix).
struct Source {
  std::array<std::uint8_t, 12> participant{};

  friend bool operator==(const Source&, const Source&) = default;
};

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace vdrive::wire {

/// The participant that sent a message (RTPS GUID prefix).
struct Source {
  std::array<std::uint8_t, 12> participant{};

  friend bool operator==(const Source&, const Source&) = default;
};

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/source.hpp"

#include <array>
#include <compare>
#include <cstdint>
#include <tuple>

namespace vdrive::wire {

/// The writer that sent a message (RTPS GUID).
struct WriterId {
  Source source{};
  std::array<std::uint8_t, 4> entity{};

  friend bool operator==(const WriterId&, const WriterId&) = default;

  friend auto operator<=>(const WriterId& one, const WriterId& other) noexcept {
    return std::tie(one.source.participant, one.entity) <=>
           std::tie(other.source.participant, other.entity);
  }
};

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "admission.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace vdrive::gateway {

/// Why a WebSocket was closed by the gateway before its client ended it.
enum class CutOff : std::uint8_t {
  silent,  ///< it sent nothing for too long
  unread,  ///< too many answers waited for it
  flood,   ///< it sent too much
};

inline constexpr std::size_t kCutOffs = 3;

/// @return such as "silent".
[[nodiscard]] std::string_view to_string(CutOff cut_off) noexcept;

/// What a server counts, from its start on where nothing else is stated.
struct WebCounters {
  std::size_t clients = 0;                         ///< WebSockets that are open now
  std::uint64_t connections = 0;                   ///< WebSockets that were opened
  std::uint64_t messages_sent = 0;                 ///< WebSocket messages given to the kernel
  std::uint64_t bytes_sent = 0;                    ///< their payload
  std::uint64_t dropped = 0;                       ///< messages left out for slow clients
  std::array<std::uint64_t, kRefusals> refused{};  ///< by Refusal
  std::array<std::uint64_t, kCutOffs> cut_off{};   ///< by CutOff
};

}  // namespace vdrive::gateway

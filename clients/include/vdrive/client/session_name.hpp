// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::client {

/// Who a session is: what its program says of itself (topic `bench_session` of the wire). Nobody
/// checks it. The texts can be shown: control characters and bytes that are not UTF-8 are written
/// as \xNN, and what is longer than 64 characters is shortened.
struct SessionName {
  std::string program{};      ///< such as "vdrive"; empty = it does not say
  std::uint32_t process = 0;  ///< its number on its host, 0 = it does not say
  std::string host{};         ///< the host's own name; empty = it does not say

  friend bool operator==(const SessionName&, const SessionName&) = default;
};

/// @return such as "vdrive (process 4711 on bench-host)".
[[nodiscard]] std::string to_string(const SessionName& name);

/// Who holds an axis that a call was refused for, or that this session has lost.
struct AxisOwner {
  AxisId axis{};                      ///< 0.0 = the bench did not name one
  std::uint64_t session = 0;          ///< not 0
  std::optional<SessionName> name{};  ///< nothing: its program says nothing, or it did not arrive

  friend bool operator==(const AxisOwner&, const AxisOwner&) = default;
};

/// @return how messages call a session: "vdrive (process 4711 on bench-host), session
///         0x000000000000000b", or "an unknown program, session 0x000000000000000b".
[[nodiscard]] std::string owner_text(std::uint64_t session, const std::optional<SessionName>& name);

/// @return such as "axis 1.1 is controlled by vdrive (process 4711 on bench-host), session
///         0x000000000000000b".
[[nodiscard]] std::string to_string(const AxisOwner& owner);

}  // namespace vdrive::client

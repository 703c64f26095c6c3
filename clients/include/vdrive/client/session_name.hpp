// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::client {

/// The name of a session, as its program states it (topic `bench_session` of the wire). It is not
/// verified. The texts are safe to display: control characters and bytes that are not UTF-8 are
/// written as \xNN, and texts longer than 64 characters are shortened.
struct SessionName {
  std::string program{};      ///< such as "vdrive"; empty = not stated
  std::uint32_t process = 0;  ///< its number on its host; 0 = not stated
  std::string host{};         ///< the host's own name; empty = not stated

  friend bool operator==(const SessionName&, const SessionName&) = default;
};

/// @return a text such as "vdrive (process 4711 on bench-host)".
[[nodiscard]] std::string to_string(const SessionName& name);

/// The session that holds an axis: a call was refused because of it, or has lost the axis to it.
struct AxisOwner {
  AxisId axis{};                      ///< 0.0 = the bench did not name one
  std::uint64_t session = 0;          ///< not 0
  std::optional<SessionName> name{};  ///< nothing: not stated, or it did not arrive

  friend bool operator==(const AxisOwner&, const AxisOwner&) = default;
};

/// @return a session as messages name it: "vdrive (process 4711 on bench-host), session
///         0x000000000000000b", or "an unknown program, session 0x000000000000000b".
[[nodiscard]] std::string owner_text(std::uint64_t session, const std::optional<SessionName>& name);

/// @return a text such as "axis 1.1 is controlled by vdrive (process 4711 on bench-host), session
///         0x000000000000000b".
[[nodiscard]] std::string to_string(const AxisOwner& owner);

}  // namespace vdrive::client

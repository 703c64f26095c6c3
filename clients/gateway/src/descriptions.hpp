// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "directory.hpp"
#include "owner_log.hpp"
#include "protocol.hpp"
#include "vdrive/client/session_name.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace vdrive::gateway {

/// The topics with JSON messages: their schemas, and the messages.

[[nodiscard]] ChannelInfo description_channel(std::string topic);
[[nodiscard]] std::string description_text(const KnownBench& bench);

[[nodiscard]] ChannelInfo state_channel(std::string topic);

/// The names of the sessions that hold axes of a bench or have held some recently, as far as their
/// programs publish them.
using OwnerNames = std::map<std::uint64_t, client::SessionName>;

/// @param time drive time [ns]
/// @param age of the newest sample
[[nodiscard]] std::string state_text(const client::BenchInfo& bench, std::uint64_t time,
                                     std::chrono::milliseconds age, bool is_alive,
                                     const OwnerNames& names = {},
                                     const std::vector<Taking>& takings = {});

/// The holder of control through this gateway.
struct ControlState {
  bool is_enabled = false;  ///< clients may command through the gateway
  std::string holder{};     ///< name of the holding connection; empty = none
  std::uint64_t session = 0;
  std::uint64_t taken_at = 0;           ///< [ns since 1970]
  std::chrono::milliseconds silence{};  ///< after which the holder counts as a lost master; 0 = no
                                        ///< holder
};

[[nodiscard]] ChannelInfo control_channel();

/// @param name of the connection that receives the message
/// @param is_holder whether it holds control
[[nodiscard]] std::string control_text(const ControlState& control, const std::string& name,
                                       bool is_holder);

[[nodiscard]] ChannelInfo dictionary_channel();

/// @return objects, modes, errors, bits, test-bench inputs and homing methods, from the core's
///         tables.
[[nodiscard]] std::string dictionary_text();

}  // namespace vdrive::gateway

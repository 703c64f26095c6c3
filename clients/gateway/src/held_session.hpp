// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "jogs.hpp"
#include "vdrive/client/session.hpp"
#include "worker.hpp"

#include <cstdint>
#include <memory>

namespace vdrive::gateway {

/// The session towards the benches of the connection that holds control.
struct HeldSession {
  std::uint64_t id = 0;
  SessionPointer session;      ///< for calls
  std::shared_ptr<Jogs> jogs;  ///< the axes that it jogs
};

/// Makes a session, and waits for it.
/// @throws std::runtime_error as client::Session does
[[nodiscard]] HeldSession open_held_session(const client::SessionOptions& options);

/// Ends a session, and does not wait: a worker does.
/// @param is_graceful what it jogs stops, and its axes are given back as they are; otherwise it
///        stops sending, and the axes react by 6007h
void end_held_session(HeldSession held, bool is_graceful, bridge::Worker& worker);

}  // namespace vdrive::gateway

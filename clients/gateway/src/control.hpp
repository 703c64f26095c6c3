// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "descriptions.hpp"
#include "jogs.hpp"
#include "vdrive/client/session.hpp"
#include "web_server.hpp"
#include "worker.hpp"

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace vdrive::gateway {

/// Who commands through the gateway: at most one connection, with a session of its own towards the
/// benches. Of the hub's thread; what waits is done by a worker.
class Control {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Control(bool is_enabled) : is_enabled_(is_enabled) {}

  ~Control();
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  [[nodiscard]] bool is_enabled() const noexcept { return is_enabled_; }

  [[nodiscard]] std::optional<ConnectionId> holder() const noexcept { return holder_; }

  [[nodiscard]] bool is_holder(ConnectionId id) const noexcept { return holder_ == id; }

  /// The session of the holder; none without one.
  [[nodiscard]] const SessionPointer& session() const noexcept { return session_; }

  [[nodiscard]] ControlState state(const std::string& holder_name) const;

  /// This connection commands from now on; a holder before it is released.
  void take(ConnectionId id, SessionPointer session);

  /// The holder commands no more: what it jogs stops, and its axes are given back as they are.
  void release();

  /// The holder is lost: its session stops sending, and the axes react by 6007h.
  void abandon();

  /// The holder jogs an axis: see Jogs::request(). Only while a connection holds control.
  void jog(const JogRequest& request, Clock::time_point now, const Jogs::Answer& answer);

  /// Drops what ended jogs have left.
  void forget_ended();

 private:
  void end(bool is_graceful);

  const bool is_enabled_;
  std::optional<ConnectionId> holder_;
  SessionPointer session_;
  std::uint64_t taken_at_ = 0;
  std::shared_ptr<Jogs> jogs_;
  bridge::Worker ends_;  ///< of sessions
};

}  // namespace vdrive::gateway

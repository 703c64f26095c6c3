// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_access.hpp"
#include "channel.hpp"
#include "client_table.hpp"
#include "hub_server.hpp"
#include "web_server.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::gateway {

/// Knows who holds control through the gateway: at most one connection, which has its own session.
/// Decides what a connection may do, and publishes the holder. Used in the server's thread;
/// sessions are opened in the threads of their connections.
class ControlDesk {
 public:
  /// The holder's program counts as a lost master after this much silence. The holder may choose a
  /// value from the shortest to the longest; the default is the longest, as for every connection.
  static constexpr std::chrono::milliseconds kShortestSilence{1'000};
  static constexpr std::chrono::milliseconds kLongestSilence = WebServer::kPatience.program;

  using Answer = Jogs::Answer;

  /// @param is_enabled clients may command through the gateway
  /// @param access outlives this object, as do `server` and `clients`
  ControlDesk(bool is_enabled, BenchAccess& access, HubServer& server, ClientTable& clients);

  /// Releases the holder's axes.
  ~ControlDesk();
  ControlDesk(const ControlDesk&) = delete;
  ControlDesk& operator=(const ControlDesk&) = delete;

  /// The topic that shows who holds control.
  [[nodiscard]] const ChannelPointer& channel() const noexcept { return channel_; }

  [[nodiscard]] bool is_held() const noexcept { return holder_.has_value(); }

  /// @return ok, or why this connection lacks the right.
  [[nodiscard]] client::Outcome check(ConnectionId id, Right right) const;

  /// @return the session of this connection; null if it does not hold control.
  [[nodiscard]] SessionPointer session_of(ConnectionId id) const;

  /// Jogs an axis for the holder of control: see Jogs::request().
  void jog(const JogRequest& request, Jogs::Clock::time_point now, const Answer& answer);

  /// An open connection requests control, a new name, or a new limit on its silence. A request with
  /// force takes control from another connection.
  /// @param answer called in the server's thread
  /// @throws ProtocolError when the request is wrong
  void take(ConnectionId id, const Json& request, const Answer& answer);

  /// Releases control, if the connection holds it.
  void release(ConnectionId id);

  /// The connection was closed. If it was lost, its axes are not released.
  void close(ConnectionId id, bool is_graceful);

  /// Sends the topic's message to one receiver.
  void send_to(ConnectionId id, std::uint32_t subscription) const;

  /// Destroys the threads of the holder's finished jogs.
  void forget_ended_jogs();

 private:
  struct Holder {
    ConnectionId id = 0;
    std::uint64_t taken_at = 0;           ///< [ns since 1970]
    std::chrono::milliseconds silence{};  ///< limit on its silence
    HeldSession session;
  };

  /// A call of /take_control.
  struct Taking {
    std::string name;  ///< empty = unchanged
    bool by_force = false;
    std::optional<std::chrono::milliseconds> silence{};  ///< none = unchanged
  };

  [[nodiscard]] static Taking taking_of(const Json& request);

  [[nodiscard]] bool is_holder(ConnectionId id) const { return holder_ && holder_->id == id; }

  [[nodiscard]] bool is_other_holder(ConnectionId id) const { return holder_ && holder_->id != id; }

  void change(Taking taking);
  void on_session(ConnectionId id, const Taking& taking, const HeldSession& session);
  void end(bool is_graceful);
  void send_to_all() const;
  [[nodiscard]] client::Outcome held_outcome() const;

  const bool is_enabled_;
  BenchAccess& access_;
  HubServer& server_;
  ClientTable& clients_;
  ChannelPointer channel_;
  std::optional<Holder> holder_;
};

}  // namespace vdrive::gateway

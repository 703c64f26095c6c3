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

/// Who commands through the gateway: at most one connection, with a session of its own towards the
/// benches. It says what a connection may do, and tells its topic who has control. Of the server's
/// thread; a session is opened in the thread of its connection.
class ControlDesk {
 public:
  /// How long the holder's program may be silent before it counts as a lost master: the holder
  /// chooses between these. Without a choice it is the longest, as for every connection.
  static constexpr std::chrono::milliseconds kShortestSilence{1'000};
  static constexpr std::chrono::milliseconds kLongestSilence = WebServer::kPatience.program;

  using Answer = Jogs::Answer;

  /// @param is_enabled the gateway lets clients command
  /// @param access outlives this, as `server` and `clients` do
  ControlDesk(bool is_enabled, BenchAccess& access, HubServer& server, ClientTable& clients);

  /// The holder gives its axes back.
  ~ControlDesk();
  ControlDesk(const ControlDesk&) = delete;
  ControlDesk& operator=(const ControlDesk&) = delete;

  /// The topic that shows who has control.
  [[nodiscard]] const ChannelPointer& channel() const noexcept { return channel_; }

  [[nodiscard]] bool is_held() const noexcept { return holder_.has_value(); }

  /// @return ok, or why this connection may not do what needs the right.
  [[nodiscard]] client::Outcome check(ConnectionId id, Right right) const;

  /// @return the session of this connection; none when it does not hold control.
  [[nodiscard]] SessionPointer session_of(ConnectionId id) const;

  /// Jogs an axis for the holder of control: see Jogs::request().
  void jog(const JogRequest& request, Jogs::Clock::time_point now, const Answer& answer);

  /// An open connection asks for control, another name or another limit of its silence. A request
  /// with force takes control over from another connection.
  /// @param answer is called in the server's thread
  /// @throws ProtocolError when the request is wrong
  void take(ConnectionId id, const Json& request, const Answer& answer);

  /// The connection gives control back, if it holds it.
  void release(ConnectionId id);

  /// The connection is closed. One that was lost does not give its axes back.
  void close(ConnectionId id, bool is_graceful);

  /// Sends the message of the topic to one receiver.
  void send_to(ConnectionId id, std::uint32_t subscription) const;

  /// Drops the threads of the holder's jogs that have ended.
  void forget_ended_jogs();

 private:
  struct Holder {
    ConnectionId id = 0;
    std::uint64_t taken_at = 0;           ///< [ns since 1970]
    std::chrono::milliseconds silence{};  ///< its limit
    HeldSession session;
  };

  /// A call of /take_control.
  struct Taking {
    std::string name;  ///< empty = as it is called already
    bool by_force = false;
    std::optional<std::chrono::milliseconds> silence{};  ///< none = as it is
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

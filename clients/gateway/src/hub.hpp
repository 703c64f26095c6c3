// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "batch_queue.hpp"
#include "bench_watch.hpp"
#include "channel_table.hpp"
#include "client_table.hpp"
#include "control_desk.hpp"
#include "event_log.hpp"
#include "graph_feed.hpp"
#include "parameter_desk.hpp"
#include "service_calls.hpp"
#include "web_server.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace vdrive::gateway {

struct HubSettings {
  double rate = 60.0;                ///< messages of a channel [1/s]
  bool is_control = false;           ///< clients may command
  bool is_token = false;             ///< clients need a token
  client::SessionOptions session{};  ///< towards the benches
};

/// Puts the parts of the gateway together: gives each message of a client to the part that it is
/// for, and each part its session, its server and its time. Of the thread of the web server.
class Hub {
 public:
  /// @param server outlives the hub
  /// @throws std::runtime_error as client::Session does
  Hub(WebServer& server, const HubSettings& settings);
  ~Hub();
  Hub(const Hub&) = delete;
  Hub& operator=(const Hub&) = delete;

  /// What the server has to report to this hub.
  [[nodiscard]] WebEvents events();

 private:
  void on_open(ConnectionId id);
  void on_bytes(ConnectionId id, bool is_text, std::string_view bytes);
  void on_close(ConnectionId id, bool is_graceful);

  void handle(ConnectionId id, const Subscribe& message);
  void handle(ConnectionId id, const Unsubscribe& message);
  void handle(ConnectionId id, const GetParameters& message);
  void handle(ConnectionId id, const SetParameters& message);
  void handle(ConnectionId id, const SubscribeParameters& message);
  void handle(ConnectionId id, const SubscribeGraph& message);
  void handle(ConnectionId id, const CallService& message);

  void begin_timers(WebServer& server);
  void send_first(ConnectionId id, std::uint32_t subscription, const Channel& channel);
  [[nodiscard]] BenchNews bench_news();
  [[nodiscard]] std::string metrics() const;

  const WebServer& web_;
  const ServerCalls server_;
  const std::string server_info_;
  const SharedBytes services_;
  const SharedBytes dictionary_;
  client::Session session_;
  EventLog events_;
  bridge::Worker session_ends_;  ///< outlives the sessions of holders
  ClientTable clients_;
  ChannelTable channels_;
  GraphFeed graph_;
  ControlDesk control_;
  ChannelPointer dictionary_channel_;
  ServiceCalls calls_;
  ParameterDesk parameters_;
  BatchQueue batches_;
  std::optional<BenchWatch> watch_;  ///< last: its threads use what is above
};

}  // namespace vdrive::gateway

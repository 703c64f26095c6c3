// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_access.hpp"
#include "bench_watch.hpp"
#include "channel_table.hpp"
#include "client_table.hpp"
#include "control_desk.hpp"
#include "event_log.hpp"
#include "graph_feed.hpp"
#include "judge_desk.hpp"
#include "parameter_desk.hpp"
#include "service_calls.hpp"
#include "web_server.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::gateway {

struct HubSettings {
  double rate = 60.0;                ///< messages per channel [1/s]
  bool is_control = false;           ///< clients may command
  bool is_token = false;             ///< clients need a token
  client::SessionOptions session{};  ///< to the benches
};

/// Connects the parts of the gateway: passes each message of a client to the part in charge, and
/// gives the parts access to the benches. Used in the thread of the web server.
class Hub final : public WebEvents, public BenchNews, private BenchAccess {
 public:
  /// @param server outlives the hub
  /// @throws std::runtime_error as client::Session does
  Hub(WebServer& server, const HubSettings& settings);
  ~Hub() override;
  Hub(const Hub&) = delete;
  Hub& operator=(const Hub&) = delete;

  void on_open(ConnectionId id) override;
  void on_message(ConnectionId id, bool is_text, std::string_view bytes) override;
  void on_close(ConnectionId id, bool is_graceful) override;
  void on_turn() override;
  [[nodiscard]] std::string metrics() const override;

 private:
  [[nodiscard]] HeldSession open() override;
  void end(HeldSession held, bool is_graceful) override;
  [[nodiscard]] CallAnswer call(const ServiceRow& row, const SessionPointer& own,
                                const Json& request) override;
  [[nodiscard]] ParameterAnswer read(const BenchList& benches,
                                     const std::vector<std::string>& names) override;
  [[nodiscard]] ParameterAnswer write(const SessionPointer& own, const BenchList& benches,
                                      const std::vector<ParameterChange>& changes) override;

  void came(std::uint32_t bench, const std::vector<ChannelPointer>& channels) override;
  void went(std::uint32_t bench, const std::vector<ChannelPointer>& channels) override;
  void publish(Batch batch) override;

  void handle(ConnectionId id, const Subscribe& message);
  void handle(ConnectionId id, const Unsubscribe& message);
  void handle(ConnectionId id, const GetParameters& message);
  void handle(ConnectionId id, const SetParameters& message);
  void handle(ConnectionId id, const SubscribeParameters& message);
  void handle(ConnectionId id, const SubscribeGraph& message);
  void handle(ConnectionId id, const CallService& message);

  void report_troubles();
  void send_first(ConnectionId id, std::uint32_t subscription, const Channel& channel);

  WebServer& server_;
  const std::string server_info_;
  const SharedBytes services_;
  const SharedBytes dictionary_;
  const client::SessionOptions options_;  ///< of all sessions
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
  JudgeDesk judges_;
  std::vector<std::string> troubles_;  ///< of the network, as last reported
  std::optional<BenchWatch> watch_;    ///< last: its threads use the members above
};

}  // namespace vdrive::gateway

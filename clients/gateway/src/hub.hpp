// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_watch.hpp"
#include "channel_table.hpp"
#include "control.hpp"
#include "parameter_watch.hpp"
#include "parameters.hpp"
#include "services.hpp"

#include <atomic>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace vdrive::gateway {

struct HubSettings {
  double rate = 60.0;                ///< messages of a channel [1/s]
  bool is_control = false;           ///< clients may command
  bool is_token = false;             ///< clients need a token
  client::SessionOptions session{};  ///< towards the benches
};

/// The protocol: what each client has subscribed, asked for and may do. Its state is of the thread
/// of the web server; calls to benches wait in workers, one a client.
class Hub {
 public:
  /// @param server outlives the hub
  /// @throws std::runtime_error as client::Session does
  Hub(WebServer& server, HubSettings settings);
  ~Hub();
  Hub(const Hub&) = delete;
  Hub& operator=(const Hub&) = delete;

  /// What the server has to report to this hub.
  [[nodiscard]] WebEvents events();

 private:
  /// One connection.
  struct Client {
    std::string name;
    bool wants_graph = false;
    std::shared_ptr<bridge::Worker> worker;
  };

  /// A call of /take_control.
  struct Taking {
    std::string name;  ///< empty = as it is called already
    bool by_force = false;
  };

  // ---- the server's events
  void on_open(ConnectionId id);
  void on_bytes(ConnectionId id, bool is_text, std::string_view bytes);
  void on_close(ConnectionId id, bool is_graceful);

  // ---- messages of clients
  void handle(ConnectionId id, const Subscribe& message);
  void handle(ConnectionId id, const Unsubscribe& message);
  void handle(ConnectionId id, const GetParameters& message);
  void handle(ConnectionId id, const SetParameters& message);
  void handle(ConnectionId id, const SubscribeParameters& message);
  void handle(ConnectionId id, const SubscribeGraph& message);
  void handle(ConnectionId id, const CallService& message);

  // ---- benches
  void post_batch(Batch batch);
  void publish(const Batch& batch);

  // ---- channels
  void send_first(ConnectionId id, std::uint32_t subscription, const Channel& channel);
  void send_control();
  void send_control_to(ConnectionId id, std::uint32_t subscription);
  void send_graphs();
  void send_graph(ConnectionId id);

  // ---- calls
  [[nodiscard]] client::Outcome check_right(ConnectionId id, Right right) const;
  void run_call(ConnectionId id, const CallService& message, const ServiceRow& row, Json request);
  void jog(ConnectionId id, const CallService& message, const Json& request);
  void change_control(ConnectionId id, const CallService& message, const ServiceRow& row,
                      const Json& request);
  void take_control(ConnectionId id, const CallService& message, const Json& request);
  void on_session(ConnectionId id, const CallService& message, const Taking& taking,
                  const SessionPointer& session, const std::string& error);
  void answer(ConnectionId id, const CallService& message, const CallAnswer& answer);
  void send_status(ConnectionId id, Level level, std::string_view text);
  [[nodiscard]] bool post(ConnectionId id, std::function<void()> job);
  void send_shared(ConnectionId id, const SharedBytes& text);
  void send_parameters(ConnectionId id, const ParameterAnswer& answer,
                       const std::optional<std::string>& request);
  void forget_workers();
  [[nodiscard]] std::string metrics() const;
  [[nodiscard]] std::string holder_name() const;
  [[nodiscard]] client::Outcome held_outcome() const;

  WebServer& server_;
  const HubSettings settings_;
  const std::string run_;  ///< the session id of the protocol
  client::Session session_;
  Control control_;
  bridge::Worker stops_;  ///< halts and quick stops of everybody
  ParameterWatch parameters_;
  std::atomic<std::size_t> client_count_ = 0;
  std::atomic<std::size_t> batches_under_way_ = 0;
  std::atomic<std::uint64_t> lost_batches_ = 0;
  std::map<ConnectionId, Client> clients_;
  ChannelTable channels_;
  ChannelPointer control_channel_;
  ChannelPointer dictionary_channel_;
  SharedBytes dictionary_;
  SharedBytes services_;
  std::vector<std::shared_ptr<bridge::Worker>> ended_;
  std::chrono::steady_clock::time_point time_sent_{};
  std::optional<BenchWatch> watch_;  ///< last: its threads use what is above
};

}  // namespace vdrive::gateway

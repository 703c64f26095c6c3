// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hub_server.hpp"

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace vdrive::gateway {

/// The server for parts of a hub, without a network: records messages by connection, and runs
/// posted actions when the test asks for it.
class RecordedServer final : public HubServer {
 public:
  void send_data(ConnectionId id, Frame frame) override;
  void send_answer(ConnectionId id, Frame frame, bool is_shared) override;
  void set_patience(ConnectionId id, Patience patience) override;
  void post(std::function<void()> action) override;

  /// @return the messages to a connection since the last call: text messages unchanged, binary ones
  ///         as head and body.
  std::vector<std::string> take(ConnectionId id);

  /// @return the same as JSON; for a binary message its body, if that is JSON.
  std::vector<Json> take_json(ConnectionId id);

  [[nodiscard]] const std::map<ConnectionId, Patience>& patience() const { return patience_; }

  /// Waits for and runs `count` posted actions.
  /// @return false if one is missing after 10 s.
  [[nodiscard]] bool run(std::size_t count = 1);

  /// Waits for a posted action.
  /// @return false after 10 s.
  [[nodiscard]] bool await();

  /// @return the number of posted actions that wait.
  [[nodiscard]] std::size_t waiting();

 private:
  std::map<ConnectionId, std::vector<Frame>> sent_;
  std::map<ConnectionId, Patience> patience_;
  std::mutex mutex_;  ///< guards the members below, since workers post
  std::condition_variable posted_;
  std::deque<std::function<void()>> actions_;
};

}  // namespace vdrive::gateway

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

/// The server of a hub's parts without a network: keeps what it is to send, by connection, and runs
/// what is posted when the test says so.
class RecordedServer final : public HubServer {
 public:
  void send_data(ConnectionId id, Frame frame) override;
  void send_answer(ConnectionId id, Frame frame, bool is_shared) override;
  void set_patience(ConnectionId id, Patience patience) override;
  void post(std::function<void()> action) override;

  /// @return the messages to a connection since the last call: text as it is, of binary ones the
  ///         head and the body.
  std::vector<std::string> take(ConnectionId id);

  /// @return the same as JSON; of a binary one its body, where that is JSON.
  std::vector<Json> take_json(ConnectionId id);

  [[nodiscard]] const std::map<ConnectionId, Patience>& patience() const { return patience_; }

  /// Runs `count` posted actions, and waits for each of them. @return false when one does not come
  /// within 10 s.
  [[nodiscard]] bool run(std::size_t count = 1);

  /// Waits until an action is posted. @return false when none comes within 10 s.
  [[nodiscard]] bool await();

  /// @return how many posted actions wait.
  [[nodiscard]] std::size_t waiting();

 private:
  std::map<ConnectionId, std::vector<Frame>> sent_;
  std::map<ConnectionId, Patience> patience_;
  std::mutex mutex_;  ///< guards what follows: workers post
  std::condition_variable posted_;
  std::deque<std::function<void()>> actions_;
};

}  // namespace vdrive::gateway

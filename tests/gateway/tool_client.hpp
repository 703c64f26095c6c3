// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gateway/web_client.hpp"
#include "tool/process.hpp"

#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace vdrive::test {

using Json = nlohmann::json;

/// A running gateway of this build, on the domain of this test.
class RunningGateway {
 public:
  /// @param words command line without the domain and the port
  explicit RunningGateway(const std::string& words = "");

  [[nodiscard]] std::uint16_t port() const noexcept { return port_; }

  [[nodiscard]] Process& process() noexcept { return process_; }

 private:
  Process process_;
  std::uint16_t port_ = 0;
};

/// A ROS 2 message: the numbers in each field; a single number is a list of one.
using RosMessage = std::map<std::string, std::vector<std::int64_t>>;

/// @param schema in ros2msg text; numbers, arrays of numbers and times are supported
/// @throws std::runtime_error if the length of `bytes` does not match.
[[nodiscard]] RosMessage decode(const std::string& schema, const std::string& bytes);

/// A message of a channel.
struct ChannelMessage {
  std::uint64_t time = 0;  ///< [ns]
  std::string payload;
};

/// A client of the protocol, as a visualisation tool would use it.
class ToolClient {
 public:
  explicit ToolClient(std::uint16_t port);
  explicit ToolClient(const WebOptions& options);

  [[nodiscard]] WebClient& web() noexcept { return web_; }

  /// @return the server's first message.
  [[nodiscard]] const Json& server_info();

  /// Waits until a topic is advertised.
  /// @return its channel.
  /// @throws std::runtime_error after 40 s.
  [[nodiscard]] Json channel(const std::string& topic);

  /// @return whether a topic is advertised now.
  [[nodiscard]] bool has_topic(const std::string& topic);

  /// Subscribes to a topic.
  void subscribe(const std::string& topic);

  /// @return the next message of a subscribed topic.
  /// @throws std::runtime_error after 40 s
  ChannelMessage next(const std::string& topic);

  /// The same as JSON, or decoded by the advertised schema.
  Json next_json(const std::string& topic);
  RosMessage next_ros(const std::string& topic);

  /// Calls a service.
  /// @return its response, or {"failure": text}.
  /// @throws std::runtime_error after 40 s.
  Json call(const std::string& service, const Json& request);

  void send(const Json& message);

  /// Waits for a text message of this operation.
  /// @throws std::runtime_error after 40 s
  Json next_text(const std::string& operation);

  /// Reads messages for this duration.
  void read_for(std::chrono::milliseconds duration);

 private:
  template <typename Condition>
  void read_until(const std::string& what, std::chrono::milliseconds patience,
                  const Condition& condition);
  void take(const WebMessage& message);
  void take_text(const Json& message);

  WebClient web_;
  Json server_info_;
  std::map<std::string, Json> channels_;
  std::map<std::string, std::uint32_t> services_;
  std::map<std::string, std::uint32_t> subscriptions_;
  std::map<std::uint32_t, std::vector<ChannelMessage>> messages_;
  std::map<std::uint32_t, Json> answers_;
  std::vector<Json> texts_;
  std::uint32_t last_id_ = 0;
};

}  // namespace vdrive::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "send_queue.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

/// The Foxglove WebSocket protocol: the messages of clients and of the gateway. Without I/O: bytes
/// in, bytes out.
namespace vdrive::gateway {

using Json = nlohmann::json;

/// @return JSON on one line; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string to_line(const Json& json);

/// The JSON schema of an object.
/// @param members such as "name:string axes?:axis[]": each with a type of JSON schema or one of
///        `types`; [] marks a list, ? after the name an optional member
/// @param types schemas by name
[[nodiscard]] Json object_schema(std::string_view members, const Json& types = Json::object());

/// The new and the old name of the protocol, whose messages are the same.
inline constexpr std::array<std::string_view, 2> kSubprotocols{"foxglove.sdk.v1",
                                                               "foxglove.websocket.v1"};

/// A client's message breaks the protocol. The text says what is wrong and where.
class ProtocolError final : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Access to members of JSON from a client. All functions throw ProtocolError with the name of the
/// member.

/// Every integer up to this one is exact as a double: 2^53.
inline constexpr double kLargestExact = 9007199254740992.0;

/// @return the member `key`, which must exist.
[[nodiscard]] const Json& member(const Json& object, const char* key);

/// @return whether an object has no member `key`, or null in its place.
[[nodiscard]] bool is_absent(const Json& object, const char* key);

[[nodiscard]] std::string as_text(const Json& value, const char* key);

/// @return the member `key` as text; none if it is absent.
[[nodiscard]] std::optional<std::string> optional_text(const Json& object, const char* key);

/// @return the results of `read` for the elements of a list.
template <typename Read>
[[nodiscard]] auto each_of(const Json& list, const Read& read) {
  std::vector<std::invoke_result_t<Read, const Json&>> values;
  values.reserve(list.size());
  for (const Json& value : list) values.push_back(read(value));
  return values;
}

/// The messages of a client.

/// A client's request to receive a channel; the protocol's term.
struct Subscription {
  std::uint32_t id = 0;  ///< chosen by the client
  std::uint32_t channel = 0;
};

struct Subscribe {
  std::vector<Subscription> subscriptions;
};

struct Unsubscribe {
  std::vector<std::uint32_t> ids;  ///< of subscriptions
};

struct GetParameters {
  std::vector<std::string> names;  ///< none = all
  std::optional<std::string> id;   ///< chosen by the client, repeated in the answer
};

struct ParameterChange {
  std::string name;
  std::int64_t value = 0;
};

struct SetParameters {
  std::vector<ParameterChange> parameters;
  std::optional<std::string> id;
};

struct SubscribeParameters {
  bool is_on = false;
  std::vector<std::string> names;
};

struct SubscribeGraph {
  bool is_on = false;
};

struct CallService {
  std::uint32_t service = 0;
  std::uint32_t call = 0;  ///< chosen by the client, repeated in the answer
  std::string encoding;
  std::string payload;
};

using ClientMessage = std::variant<Subscribe, Unsubscribe, GetParameters, SetParameters,
                                   SubscribeParameters, SubscribeGraph, CallService>;

/// @throws ProtocolError when `text` is not a message that this gateway supports.
[[nodiscard]] ClientMessage parse_text(std::string_view text);

/// @throws ProtocolError as parse_text does.
[[nodiscard]] ClientMessage parse_binary(std::string_view bytes);

/// The severity of a status message.
enum class Level : std::uint8_t { info = 0, warning = 1, error = 2 };

/// A channel as announced to clients.
struct ChannelInfo {
  std::uint32_t id = 0;
  std::string topic;
  std::string encoding;
  std::string schema_name;
  std::string schema;
  std::string schema_encoding;
};

/// A service as announced to clients. The schemas are JSON schemas.
struct ServiceInfo {
  std::uint32_t id = 0;
  std::string name;
  std::string type;
  Json request_schema;
  Json response_schema;
};

/// A parameter and its value; none: the drive refused to read it.
struct Parameter {
  std::string name;
  std::optional<std::int64_t> value;
};

struct ServerInfo {
  bool is_control = false;  ///< clients may command
  bool is_token = false;    ///< clients need a token
  std::string version;
  std::string session;  ///< unique to each run
};

/// A topic or a service, with those who publish, receive or offer it.
struct GraphEntry {
  std::string name;
  std::vector<std::string> ids;
};

struct Graph {
  std::vector<GraphEntry> published;
  std::vector<GraphEntry> subscribed;
  std::vector<GraphEntry> services;
  std::vector<std::string> removed_topics;
};

/// Text messages.
[[nodiscard]] std::string server_info_text(const ServerInfo& info);
[[nodiscard]] std::string advertise_text(std::span<const ChannelInfo> channels);
[[nodiscard]] std::string unadvertise_text(std::span<const std::uint32_t> channels);
[[nodiscard]] std::string advertise_services_text(std::span<const ServiceInfo> services);
[[nodiscard]] std::string status_text(Level level, std::string_view message);

/// A warning about the gateway's network, which clients show until it is removed; without troubles,
/// its removal.
/// @param troubles from Session::network_troubles()
[[nodiscard]] std::string network_text(const std::vector<std::string>& troubles);
[[nodiscard]] std::string parameters_text(std::span<const Parameter> parameters,
                                          const std::optional<std::string>& id);
[[nodiscard]] std::string graph_text(const Graph& graph);
[[nodiscard]] std::string call_failure_text(std::uint32_t service, std::uint32_t call,
                                            std::string_view message);

/// Binary messages.
[[nodiscard]] Frame message_frame(std::uint32_t subscription, std::uint64_t time,
                                  SharedBytes payload);
[[nodiscard]] Frame time_frame(std::uint64_t time);
[[nodiscard]] Frame response_frame(std::uint32_t service, std::uint32_t call,
                                   std::string_view payload);

}  // namespace vdrive::gateway

// SPDX-License-Identifier: Apache-2.0
#include "protocol.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/text.hpp"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <utility>

namespace vdrive::gateway {
namespace {

// First byte of a binary message. Each direction has its own numbers.
constexpr std::uint8_t kMessageData = 1;  // in both directions
constexpr std::uint8_t kTime = 2;         // from the server
constexpr std::uint8_t kServiceRequest = 2;
constexpr std::uint8_t kServiceResponse = 3;

constexpr std::string_view kJsonEncoding = "json";
constexpr std::string_view kJsonSchema = "jsonschema";

// ---- messages of clients

/// @return the results of `read` for the elements of the member `key`.
template <typename Read>
auto list_of(const Json& object, const char* key, const Read& read) {
  const Json& list = member(object, key);
  if (!list.is_array()) throw ProtocolError(in_quotes(key) + " must be an array");
  return each_of(list, [&](const Json& value) {
    return read(value, key);
  });
}

// Numbers of the protocol have 32 bits, which a JSON number holds exactly.
std::uint32_t as_number(const Json& value, const char* key) {
  if (value.is_number_integer()) {
    const auto number = value.get<std::int64_t>();
    if (number >= 0 && number <= std::numeric_limits<std::uint32_t>::max()) {
      return static_cast<std::uint32_t>(number);
    }
  }
  throw ProtocolError(in_quotes(key) + " must be a number from 0 to 4294967295");
}

Subscription as_subscription(const Json& value, const char* /*key*/) {
  return {.id = as_number(member(value, "id"), "id"),
          .channel = as_number(member(value, "channelId"), "channelId")};
}

/// Tools send 1 as 1.0, and switches as true and false.
std::int64_t value_of(const Json& value, const std::string& name) {
  if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
  if (value.is_number_unsigned() &&
      value.get<std::uint64_t>() <= std::uint64_t{std::numeric_limits<std::int64_t>::max()}) {
    return static_cast<std::int64_t>(value.get<std::uint64_t>());
  }
  // The library also counts unsigned numbers as integers: one above 2^63 would become negative.
  if (value.is_number_integer() && !value.is_number_unsigned()) return value.get<std::int64_t>();
  if (value.is_number_float()) {
    const auto number = value.get<double>();
    if (std::isfinite(number) && std::trunc(number) == number &&
        std::abs(number) <= kLargestExact) {
      return static_cast<std::int64_t>(number);
    }
  }
  throw ProtocolError("the value of " + in_quotes(name) + " must be a whole number");
}

ParameterChange as_change(const Json& value, const char* /*key*/) {
  std::string name = as_text(member(value, "name"), "name");
  const std::int64_t number = value_of(member(value, "value"), name);
  return {.name = std::move(name), .value = number};
}

std::vector<std::string> names_of(const Json& message) {
  return list_of(message, "parameterNames", as_text);
}

ClientMessage parse_subscribe(const Json& message) {
  return Subscribe{list_of(message, "subscriptions", as_subscription)};
}

ClientMessage parse_unsubscribe(const Json& message) {
  return Unsubscribe{list_of(message, "subscriptionIds", as_number)};
}

ClientMessage parse_get_parameters(const Json& message) {
  return GetParameters{.names = names_of(message), .id = optional_text(message, "id")};
}

ClientMessage parse_set_parameters(const Json& message) {
  auto id = optional_text(message, "id");
  return SetParameters{.parameters = list_of(message, "parameters", as_change),
                       .id = std::move(id)};
}

template <bool is_on>
ClientMessage parse_parameter_updates(const Json& message) {
  return SubscribeParameters{.is_on = is_on, .names = names_of(message)};
}

template <bool is_on>
ClientMessage parse_graph_updates(const Json& /*message*/) {
  return SubscribeGraph{.is_on = is_on};
}

struct OperationRow {
  std::string_view name;
  ClientMessage (*parse)(const Json& message);
};

constexpr std::array kOperations{
    OperationRow{"subscribe", parse_subscribe},
    OperationRow{"unsubscribe", parse_unsubscribe},
    OperationRow{"getParameters", parse_get_parameters},
    OperationRow{"setParameters", parse_set_parameters},
    OperationRow{"subscribeParameterUpdates", parse_parameter_updates<true>},
    OperationRow{"unsubscribeParameterUpdates", parse_parameter_updates<false>},
    OperationRow{"subscribeConnectionGraph", parse_graph_updates<true>},
    OperationRow{"unsubscribeConnectionGraph", parse_graph_updates<false>},
};

template <typename Number>
Number take(std::string_view& bytes, const char* what) {
  static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");
  if (bytes.size() < sizeof(Number)) {
    throw ProtocolError(std::string("the message ends before its ") + what);
  }
  Number number{};
  std::memcpy(&number, bytes.data(), sizeof(Number));
  bytes.remove_prefix(sizeof(Number));
  return number;
}

// ---- messages of the server

template <typename Number>
void put(Frame& frame, Number number) {
  ensure(frame.head_size + sizeof(Number) <= frame.head.size(), "a head has room for its numbers");
  std::memcpy(frame.head.data() + frame.head_size, &number, sizeof(Number));
  frame.head_size = static_cast<std::uint8_t>(frame.head_size + sizeof(Number));
}

Json graph_entries(const std::vector<GraphEntry>& entries, const char* ids) {
  Json list = Json::array();
  for (const GraphEntry& entry : entries) list.push_back({{"name", entry.name}, {ids, entry.ids}});
  return list;
}

Json message_schema(const std::string& name, const Json& schema) {
  return {{"encoding", kJsonEncoding},
          {"schemaName", name},
          {"schemaEncoding", kJsonSchema},
          {"schema", to_line(schema)}};
}

Json type_schema(const std::string& type, const Json& types) {
  if (type.ends_with("[]")) {
    return {{"type", "array"}, {"items", type_schema(type.substr(0, type.size() - 2), types)}};
  }
  return types.value(type, Json{{"type", type}});
}

}  // namespace

std::string to_line(const Json& json) {
  // Names come from benches and clients: bytes that are not UTF-8 must not cause an exception.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json object_schema(std::string_view members, const Json& types) {
  Json properties = Json::object();
  Json required = Json::array();
  std::istringstream stream{std::string(members)};
  for (std::string member; stream >> member;) {
    const auto colon = member.find(':');
    std::string name = member.substr(0, colon);
    if (name.ends_with('?')) {
      name.pop_back();
    } else {
      required.push_back(name);
    }
    properties[name] = type_schema(member.substr(colon + 1), types);
  }
  return {
      {"type", "object"}, {"properties", std::move(properties)}, {"required", std::move(required)}};
}

const Json& member(const Json& object, const char* key) {
  if (!object.is_object()) throw ProtocolError("expected an object with the key " + in_quotes(key));
  const auto found = object.find(key);
  if (found == object.end()) throw ProtocolError("the key " + in_quotes(key) + " is missing");
  return *found;
}

bool is_absent(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() || found->is_null();
}

std::string as_text(const Json& value, const char* key) {
  if (!value.is_string()) throw ProtocolError(in_quotes(key) + " must be a string");
  return value.get<std::string>();
}

std::optional<std::string> optional_text(const Json& object, const char* key) {
  if (is_absent(object, key)) return std::nullopt;
  return as_text(member(object, key), key);
}

ClientMessage parse_text(std::string_view text) {
  const Json message = Json::parse(text, nullptr, false);
  if (message.is_discarded()) throw ProtocolError("the text is not JSON");
  const std::string name = as_text(member(message, "op"), "op");
  for (const OperationRow& row : kOperations) {
    if (row.name == name) return row.parse(message);
  }
  throw ProtocolError("the operation " + in_quotes(name) + " is not supported by this server");
}

ClientMessage parse_binary(std::string_view bytes) {
  const auto operation = take<std::uint8_t>(bytes, "operation");
  if (operation == kMessageData)
    throw ProtocolError("this server accepts no messages from clients");
  if (operation != kServiceRequest) {
    throw ProtocolError("the binary operation " + std::to_string(operation) +
                        " is not supported by this server");
  }
  CallService call;
  call.service = take<std::uint32_t>(bytes, "service");
  call.call = take<std::uint32_t>(bytes, "call");
  const auto length = take<std::uint32_t>(bytes, "length of the encoding");
  if (length > bytes.size()) throw ProtocolError("the message ends before its encoding");
  call.encoding = bytes.substr(0, length);
  call.payload = bytes.substr(length);
  return call;
}

std::string server_info_text(const ServerInfo& info) {
  return to_line({{"op", "serverInfo"},
                  {"name", "vdrive-gateway"},
                  {"capabilities", Json::array({"time", "parameters", "parametersSubscribe",
                                                "services", "connectionGraph"})},
                  {"supportedEncodings", Json::array({kJsonEncoding})},
                  {"metadata",
                   {{"version", info.version},
                    {"control", info.is_control ? "true" : "false"},
                    {"token", info.is_token ? "true" : "false"}}},
                  {"sessionId", info.session}});
}

std::string advertise_text(std::span<const ChannelInfo> channels) {
  Json list = Json::array();
  for (const ChannelInfo& channel : channels) {
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic},
                    {"encoding", channel.encoding},
                    {"schemaName", channel.schema_name},
                    {"schema", channel.schema},
                    {"schemaEncoding", channel.schema_encoding}});
  }
  return to_line({{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string unadvertise_text(std::span<const std::uint32_t> channels) {
  return to_line(
      {{"op", "unadvertise"}, {"channelIds", std::vector(channels.begin(), channels.end())}});
}

std::string advertise_services_text(std::span<const ServiceInfo> services) {
  Json list = Json::array();
  for (const ServiceInfo& service : services) {
    list.push_back(
        {{"id", service.id},
         {"name", service.name},
         {"type", service.type},
         {"request", message_schema(service.type + "Request", service.request_schema)},
         {"response", message_schema(service.type + "Response", service.response_schema)}});
  }
  return to_line({{"op", "advertiseServices"}, {"services", std::move(list)}});
}

std::string status_text(Level level, std::string_view message) {
  return to_line(
      {{"op", "status"}, {"level", static_cast<int>(level)}, {"message", std::string(message)}});
}

std::string network_text(const std::vector<std::string>& troubles) {
  constexpr const char* kId = "network";
  if (troubles.empty()) return to_line({{"op", "removeStatus"}, {"statusIds", {kId}}});
  return to_line({{"op", "status"},
                  {"level", static_cast<int>(Level::warning)},
                  {"message", joined(troubles, "; ")},
                  {"id", kId}});
}

std::string parameters_text(std::span<const Parameter> parameters,
                            const std::optional<std::string>& id) {
  Json list = Json::array();
  for (const Parameter& parameter : parameters) {
    Json entry{{"name", parameter.name}};
    if (parameter.value) entry["value"] = *parameter.value;
    list.push_back(std::move(entry));
  }
  Json message{{"op", "parameterValues"}, {"parameters", std::move(list)}};
  if (id) message["id"] = *id;
  return to_line(message);
}

std::string graph_text(const Graph& graph) {
  return to_line({{"op", "connectionGraphUpdate"},
                  {"publishedTopics", graph_entries(graph.published, "publisherIds")},
                  {"subscribedTopics", graph_entries(graph.subscribed, "subscriberIds")},
                  {"advertisedServices", graph_entries(graph.services, "providerIds")},
                  {"removedTopics", graph.removed_topics},
                  {"removedServices", Json::array()}});
}

std::string call_failure_text(std::uint32_t service, std::uint32_t call, std::string_view message) {
  return to_line({{"op", "serviceCallFailure"},
                  {"serviceId", service},
                  {"callId", call},
                  {"message", std::string(message)}});
}

Frame message_frame(std::uint32_t subscription, std::uint64_t time, SharedBytes payload) {
  Frame frame;
  put(frame, kMessageData);
  put(frame, subscription);
  put(frame, time);
  frame.body = std::move(payload);
  return frame;
}

Frame time_frame(std::uint64_t time) {
  Frame frame;
  put(frame, kTime);
  put(frame, time);
  return frame;
}

Frame response_frame(std::uint32_t service, std::uint32_t call, std::string_view payload) {
  Frame frame;
  put(frame, kServiceResponse);
  put(frame, service);
  put(frame, call);
  // The head has a fixed capacity, so the body has the rest: length of the encoding, encoding,
  // payload.
  std::string body(sizeof(std::uint32_t), '\0');
  const auto length = static_cast<std::uint32_t>(kJsonEncoding.size());
  std::memcpy(body.data(), &length, sizeof(length));
  frame.body = std::make_shared<const std::string>(body.append(kJsonEncoding).append(payload));
  return frame;
}

}  // namespace vdrive::gateway

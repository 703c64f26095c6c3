// SPDX-License-Identifier: Apache-2.0
#include "gateway/tool_client.hpp"

#include "support/deadline.hpp"
#include "support/test_domain.hpp"

#include <algorithm>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;

constexpr auto kLongest = 40s;  // on a busy machine

std::vector<std::string> gateway_arguments(const std::string& words) {
  std::vector<std::string> arguments{"--domain", std::to_string(test_domain()), "--listen",
                                     "127.0.0.1:0"};
  std::istringstream text(words);
  for (std::string word; text >> word;) arguments.push_back(word);
  return arguments;
}

template <typename Number>
Number number_at(const std::string& bytes, std::size_t place) {
  if (place + sizeof(Number) > bytes.size()) throw std::runtime_error("the message is too short");
  Number number{};
  std::memcpy(&number, bytes.data() + place, sizeof(Number));
  return number;
}

/// Reads plain CDR after its header of four bytes.
class Reader {
 public:
  explicit Reader(const std::string& bytes) : bytes_(bytes.substr(4)) {}

  std::int64_t number(const std::string& type) {
    if (type == "int8") return take<std::int8_t>();
    if (type == "uint8") return take<std::uint8_t>();
    if (type == "int16") return take<std::int16_t>();
    if (type == "uint16") return take<std::uint16_t>();
    if (type == "int32") return take<std::int32_t>();
    if (type == "uint32") return take<std::uint32_t>();
    if (type == "uint64") return static_cast<std::int64_t>(take<std::uint64_t>());
    throw std::runtime_error("unknown type " + type);
  }

  [[nodiscard]] bool is_at_end() const { return place_ == bytes_.size(); }

 private:
  template <typename Number>
  Number take() {
    place_ = (place_ + sizeof(Number) - 1) / sizeof(Number) * sizeof(Number);
    const auto number = number_at<Number>(bytes_, place_);
    place_ += sizeof(Number);
    return number;
  }

  std::string bytes_;
  std::size_t place_ = 0;
};

}  // namespace

RunningGateway::RunningGateway(const std::string& words)
    : process_(VDRIVE_GATEWAY, gateway_arguments(words)) {
  const std::string line = process_.read_line();
  const auto colon = line.find("127.0.0.1:");
  if (colon == std::string::npos) throw std::runtime_error("the gateway did not start: " + line);
  port_ = static_cast<std::uint16_t>(std::stoi(line.substr(colon + 10)));
}

RosMessage decode(const std::string& schema, const std::string& bytes) {
  RosMessage message;
  Reader reader(bytes);
  std::istringstream text(schema);
  for (std::string line; std::getline(text, line) && !line.starts_with("===");) {
    const auto blank = line.find(' ');
    std::string type = line.substr(0, blank);
    std::vector<std::int64_t>& values = message[line.substr(blank + 1)];
    if (type == "builtin_interfaces/Time") {
      values = {reader.number("int32"), reader.number("uint32")};
      continue;
    }
    std::int64_t count = 1;
    if (type.ends_with("[]")) {
      type.resize(type.size() - 2);
      count = reader.number("uint32");
    }
    for (; count > 0; --count) values.push_back(reader.number(type));
  }
  if (!reader.is_at_end()) throw std::runtime_error("the message is too long");
  return message;
}

ToolClient::ToolClient(std::uint16_t port) : ToolClient(WebOptions{.port = port}) {}

ToolClient::ToolClient(const WebOptions& options) : web_(options) {}

template <typename Condition>
void ToolClient::read_until(const std::string& what, std::chrono::milliseconds patience,
                            const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left <= 0ms) throw std::runtime_error(missed_deadline("there was no " + what, patience));
    if (const auto message = web_.receive(left)) {
      take(*message);
    } else if (web_.has_ended()) {
      throw std::runtime_error("the connection ended before " + what);
    }
  }
}

void ToolClient::take(const WebMessage& message) {
  if (message.is_text) {
    take_text(Json::parse(message.bytes));
    return;
  }
  constexpr std::size_t kPayload = 13;
  switch (message.bytes.at(0)) {
    case 1:
      messages_[number_at<std::uint32_t>(message.bytes, 1)].push_back(
          {number_at<std::uint64_t>(message.bytes, 5), message.bytes.substr(kPayload)});
      break;
    case 2:
      texts_.push_back({{"op", "time"}, {"time", number_at<std::uint64_t>(message.bytes, 1)}});
      break;
    case 3: {
      const auto length = number_at<std::uint32_t>(message.bytes, 9);
      answers_[number_at<std::uint32_t>(message.bytes, 5)] =
          Json::parse(message.bytes.substr(kPayload + length));
      break;
    }
    default:
      throw std::runtime_error("unknown binary message");
  }
}

void ToolClient::take_text(const Json& message) {
  const std::string operation = message.at("op");
  if (operation == "serverInfo") {
    server_info_ = message;
  } else if (operation == "advertise") {
    for (const Json& channel : message.at("channels")) channels_[channel.at("topic")] = channel;
  } else if (operation == "unadvertise") {
    for (const Json& id : message.at("channelIds")) {
      std::erase_if(channels_, [&](const auto& channel) {
        return channel.second.at("id") == id;
      });
    }
  } else if (operation == "advertiseServices") {
    for (const Json& service : message.at("services")) {
      services_[service.at("name")] = service.at("id");
    }
  } else if (operation == "serviceCallFailure") {
    answers_[message.at("callId")] = {{"failure", message.at("message")}};
  } else {
    texts_.push_back(message);
  }
}

const Json& ToolClient::server_info() {
  read_until("serverInfo", kLongest, [&] {
    return !server_info_.is_null();
  });
  return server_info_;
}

Json ToolClient::channel(const std::string& topic) {
  read_until("topic " + topic, kLongest, [&] {
    return channels_.contains(topic);
  });
  return channels_.at(topic);
}

bool ToolClient::has_topic(const std::string& topic) {
  return channels_.contains(topic);
}

void ToolClient::subscribe(const std::string& topic) {
  const Json found = channel(topic);
  const std::uint32_t id = ++last_id_;
  subscriptions_[topic] = id;
  send({{"op", "subscribe"},
        {"subscriptions", Json::array({{{"id", id}, {"channelId", found.at("id")}}})}});
}

ChannelMessage ToolClient::next(const std::string& topic) {
  auto& messages = messages_[subscriptions_.at(topic)];
  read_until("message of " + topic, kLongest, [&] {
    return !messages.empty();
  });
  ChannelMessage message = std::move(messages.front());
  messages.erase(messages.begin());
  return message;
}

Json ToolClient::next_json(const std::string& topic) {
  return Json::parse(next(topic).payload);
}

RosMessage ToolClient::next_ros(const std::string& topic) {
  return decode(channels_.at(topic).at("schema"), next(topic).payload);
}

Json ToolClient::call(const std::string& service, const Json& request) {
  read_until("service " + service, kLongest, [&] {
    return services_.contains(service);
  });
  const std::uint32_t call = ++last_id_;
  std::string bytes(13, '\2');
  const std::uint32_t id = services_.at(service);
  const std::uint32_t length = 4;
  std::memcpy(bytes.data() + 1, &id, sizeof(id));
  std::memcpy(bytes.data() + 5, &call, sizeof(call));
  std::memcpy(bytes.data() + 9, &length, sizeof(length));
  web_.send(bytes + "json" + request.dump(), false);
  read_until("answer of " + service, kLongest, [&] {
    return answers_.contains(call);
  });
  return std::exchange(answers_[call], {});
}

void ToolClient::send(const Json& message) {
  web_.send(message.dump(), true);
}

Json ToolClient::next_text(const std::string& operation) {
  const auto is_wanted = [&](const Json& text) {
    return text.at("op") == operation;
  };
  read_until("message " + operation, kLongest, [&] {
    return std::ranges::any_of(texts_, is_wanted);
  });
  const auto found = std::ranges::find_if(texts_, is_wanted);
  Json message = *found;
  texts_.erase(found);
  return message;
}

void ToolClient::read_for(std::chrono::milliseconds duration) {
  const auto deadline = std::chrono::steady_clock::now() + duration;
  while (true) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left <= 0ms || web_.has_ended()) return;
    if (const auto message = web_.receive(left)) take(*message);
  }
}

}  // namespace vdrive::test

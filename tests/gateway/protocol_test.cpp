// SPDX-License-Identifier: Apache-2.0
#include "protocol.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace vdrive::gateway {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// @return the error about a message; empty if there is none.
template <typename Parse>
std::string complaint(const Parse& parse) {
  try {
    (void)parse();
  } catch (const ProtocolError& error) {
    return error.what();
  }
  return {};
}

std::string text_complaint(const std::string& text) {
  return complaint([&] {
    return parse_text(text);
  });
}

std::string binary_complaint(const std::string& bytes) {
  return complaint([&] {
    return parse_binary(bytes);
  });
}

TEST(Protocol, ReadsSubscriptions) {
  const auto message = std::get<Subscribe>(parse_text(
      R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":7},{"id":4294967295,"channelId":0}]})"));
  ASSERT_EQ(message.subscriptions.size(), 2U);
  EXPECT_EQ(message.subscriptions[0].channel, 7U);
  EXPECT_EQ(message.subscriptions[1].id, 4294967295U);
  const auto end =
      std::get<Unsubscribe>(parse_text(R"({"op":"unsubscribe","subscriptionIds":[1,2]})"));
  EXPECT_THAT(end.ids, ElementsAre(1, 2));
}

TEST(Protocol, ReadsParameters) {
  const auto get = std::get<GetParameters>(
      parse_text(R"({"op":"getParameters","parameterNames":["bench1/x/0x6081"],"id":"a"})"));
  EXPECT_THAT(get.names, ElementsAre("bench1/x/0x6081"));
  EXPECT_EQ(get.id, "a");
  const auto set = std::get<SetParameters>(parse_text(
      R"({"op":"setParameters","parameters":[{"name":"p","value":-5},{"name":"q","value":3.0},{"name":"r","value":true}]})"));
  ASSERT_EQ(set.parameters.size(), 3U);
  EXPECT_EQ(set.parameters[0].value, -5);
  EXPECT_EQ(set.parameters[1].value, 3);
  EXPECT_EQ(set.parameters[2].value, 1);
  EXPECT_EQ(set.id, std::nullopt);
}

TEST(Protocol, DescribesTheErrorOfAMessage) {
  EXPECT_THAT(text_complaint("{"), HasSubstr("not JSON"));
  EXPECT_THAT(text_complaint("[]"), HasSubstr("object"));
  EXPECT_THAT(text_complaint("{}"), HasSubstr("'op' is missing"));
  EXPECT_THAT(text_complaint(R"({"op":"dance"})"), HasSubstr("'dance'"));
  EXPECT_THAT(text_complaint(R"({"op":"subscribe"})"), HasSubstr("'subscriptions'"));
  EXPECT_THAT(text_complaint(R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})"),
              HasSubstr("0 to 4294967295"));
  EXPECT_THAT(
      text_complaint(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":4294967296}]})"),
      HasSubstr("'channelId'"));
  EXPECT_THAT(text_complaint(R"({"op":"setParameters","parameters":[{"name":"p","value":1.5}]})"),
              HasSubstr("whole number"));
  EXPECT_THAT(text_complaint(R"({"op":"setParameters","parameters":[{"name":"p","value":1e300}]})"),
              HasSubstr("whole number"));
  EXPECT_THAT(
      text_complaint(
          R"({"op":"setParameters","parameters":[{"name":"p","value":18446744073709551615}]})"),
      HasSubstr("whole number"));
}

/// 02, service, call, length of the encoding, encoding, payload.
const std::string kCall = std::string("\2\3\0\0\0\4\0\0\0\4\0\0\0json{}", 19);

TEST(Protocol, ReadsAServiceCall) {
  const auto call = std::get<CallService>(parse_binary(kCall));
  EXPECT_EQ(call.service, 3U);
  EXPECT_EQ(call.call, 4U);
  EXPECT_EQ(call.encoding, "json");
  EXPECT_EQ(call.payload, "{}");
}

TEST(Protocol, RefusesACallWithoutItsWholePayload) {
  for (std::size_t length = 0; length < kCall.size() - 2; ++length) {
    EXPECT_THAT(binary_complaint(kCall.substr(0, length)), HasSubstr("ends before")) << length;
  }
  EXPECT_EQ(binary_complaint(kCall.substr(0, kCall.size() - 2)), "") << "an empty payload";
}

TEST(Protocol, RefusesMessagesOfClientsAndUnknownOperations) {
  EXPECT_THAT(binary_complaint("\1abcdefgh"), HasSubstr("no messages from clients"));
  EXPECT_THAT(binary_complaint("\x7f"), HasSubstr("127"));
}

TEST(Protocol, WritesMessageDataWithSubscriptionAndTime) {
  const Frame frame =
      message_frame(0x01020304, 0x1122334455667788, std::make_shared<const std::string>("payload"));
  EXPECT_FALSE(frame.is_text);
  EXPECT_EQ(std::string(frame.head.data(), frame.head_size),
            std::string("\1\4\3\2\1\x88\x77\x66\x55\x44\x33\x22\x11"));
  EXPECT_EQ(*frame.body, "payload");
  EXPECT_EQ(frame.size(), 20U);  // 1 + 4 + 8 + 7
}

TEST(Protocol, WritesTheTimeInNineBytes) {
  const Frame frame = time_frame(1);
  EXPECT_EQ(std::string(frame.head.data(), frame.head_size), std::string("\2\1\0\0\0\0\0\0\0", 9));
}

TEST(Protocol, WritesAServiceResponse) {
  const Frame frame = response_frame(3, 4, "{}");
  EXPECT_EQ(std::string(frame.head.data(), frame.head_size) + *frame.body,
            std::string("\3\3\0\0\0\4\0\0\0\4\0\0\0json{}", 19));
}

TEST(Protocol, DescribesTheCapabilitiesOfTheServer) {
  const Json info = Json::parse(server_info_text(
      {.is_control = true, .is_token = false, .version = "1.2.3", .session = "s"}));
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["name"], "vdrive-gateway");
  EXPECT_EQ(info["capabilities"],
            Json({"time", "parameters", "parametersSubscribe", "services", "connectionGraph"}));
  EXPECT_EQ(info["supportedEncodings"], Json::array({"json"}));
  EXPECT_EQ(info["metadata"]["control"], "true");
  EXPECT_EQ(info["metadata"]["version"], "1.2.3");
}

TEST(Protocol, AdvertisesAndUnadvertisesChannels) {
  const std::vector<ChannelInfo> channels{{.id = 5,
                                           .topic = "/bench1/status",
                                           .encoding = "cdr",
                                           .schema_name = "a",
                                           .schema = "uint8 x\n",
                                           .schema_encoding = "ros2msg"}};
  const Json advertised = Json::parse(advertise_text(channels));
  EXPECT_EQ(advertised["channels"][0]["topic"], "/bench1/status");
  EXPECT_EQ(advertised["channels"][0]["schema"], "uint8 x\n");
  const std::array<std::uint32_t, 2> ids{5, 6};
  EXPECT_EQ(Json::parse(unadvertise_text(ids))["channelIds"], Json({5, 6}));
}

// A status with an id stays until it is removed by that id:
// https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md#remove-status
TEST(Protocol, ShowsTroublesOfTheNetworkUntilTheyEnd) {
  const std::vector<std::string> troubles{"a is away", "b is away"};
  const Json shown{
      {"op", "status"}, {"level", 1}, {"message", "a is away; b is away"}, {"id", "network"}};
  EXPECT_EQ(Json::parse(network_text(troubles)), shown);
  const Json removed = {{"op", "removeStatus"}, {"statusIds", {"network"}}};
  EXPECT_EQ(Json::parse(network_text({})), removed);
}

TEST(Protocol, OmitsAValueThatADriveRefuses) {
  const std::vector<Parameter> parameters{{.name = "a", .value = 7}, {.name = "b", .value = {}}};
  const Json values = Json::parse(parameters_text(parameters, "request"));
  EXPECT_EQ(values["id"], "request");
  EXPECT_EQ(values["parameters"][0]["value"], 7);
  EXPECT_FALSE(values["parameters"][1].contains("value"));
  EXPECT_FALSE(Json::parse(parameters_text(parameters, {})).contains("id"));
}

}  // namespace
}  // namespace vdrive::gateway

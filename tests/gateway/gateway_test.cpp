// SPDX-License-Identifier: Apache-2.0
// The program vdrive-gateway between a service and WebSocket clients.
#include "gateway/tool_client.hpp"
#include "support/deadline.hpp"
#include "support/temporary_directory.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <memory>
#include <set>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using client::Session;
using testing::HasSubstr;
using testing::StartsWith;

constexpr std::uint16_t kLostMaster = 0x8130;

client::SessionOptions options() {
  client::SessionOptions options;
  options.domain = test_domain();
  options.find_timeout = 20s;
  return options;
}

/// @return whether the condition holds within 10 s of wall-clock time.
template <typename Condition>
bool soon(const Condition& condition) {
  constexpr auto kPatience = 10s;
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < deadline) {
    if (condition()) return true;
  }
  report_missed_deadline("the condition did not hold", kPatience);
  return false;
}

std::string axis_topic(Session& session, const std::string& suffix) {
  return "/bench1/" + session.find_bench(1)->axes[0].name + suffix;
}

std::string parameter(Session& session, const std::string& object) {
  return axis_topic(session, "/" + object).substr(1);
}

// ---- admission

/// @return the answer to a refused WebSocket upgrade.
std::string upgrade(std::uint16_t port, const std::string& subprotocol, const std::string& origin) {
  std::string request =
      "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
      "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n";
  if (!subprotocol.empty()) request += "Sec-WebSocket-Protocol: " + subprotocol + "\r\n";
  if (!origin.empty()) request += "Origin: " + origin + "\r\n";
  return http_exchange(port, request + "\r\n");
}

TEST(GatewayConnection, AsksForAdmission) {
  const RunningGateway gateway;
  for (const char* name : {"foxglove.sdk.v1", "foxglove.websocket.v1"}) {
    ToolClient client(WebOptions{.port = gateway.port(), .subprotocol = name});
    EXPECT_EQ(client.web().subprotocol(), name);
    EXPECT_EQ(client.server_info()["name"], "vdrive-gateway");
  }
  EXPECT_THAT(upgrade(gateway.port(), "mqtt", ""), StartsWith("HTTP/1.1 400"));
  const std::string own = "http://127.0.0.1:" + std::to_string(gateway.port());
  EXPECT_NO_THROW(WebClient({.port = gateway.port(), .origin = own}));
  const std::string refusal = upgrade(gateway.port(), "foxglove.sdk.v1", "http://evil.example");
  EXPECT_THAT(refusal, StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(refusal, HasSubstr("http://evil.example"));
}

TEST(GatewayConnection, NeedsATokenOffLoopback) {
  const Finished finished = Process(VDRIVE_GATEWAY, {"--listen", "0.0.0.0:0"}).wait();
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors, HasSubstr("--token"));
}

TEST(GatewayCommandLine, FailsWhenItsAnswerCouldNotBeWritten) {
  for (const std::string flag : {"--help", "--version"}) {
    const Finished full =
        Process("/bin/sh", {"-c", VDRIVE_GATEWAY " " + flag + " > /dev/full"}).wait();
    EXPECT_EQ(full.code, 1) << flag;
    EXPECT_THAT(full.errors, HasSubstr("standard output could not be written: No space left"));
  }
}

TEST(GatewayCommandLine, PrintsItsHelpIntoAPipe) {
  const Finished help = Process(VDRIVE_GATEWAY, {"--help"}).wait();
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.output, HasSubstr("--listen"));
  EXPECT_EQ(Process(VDRIVE_GATEWAY, {"--lisen", "x"}).wait().code, 2);
  EXPECT_THAT(Process(VDRIVE_GATEWAY, {"--version"}).wait().output, StartsWith("vdrive-gateway "));
}

TEST(GatewayConnection, ServesThePageWithItsPolicy) {
  const RunningGateway gateway;
  const std::string page = http_exchange(
      gateway.port(), "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy: default-src 'self'"));
  EXPECT_THAT(page, HasSubstr("text/html"));
  EXPECT_THAT(http_exchange(gateway.port(),
                            "GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(http_exchange(gateway.port(),
                            "POST / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 405"));
}

TEST(GatewayConnection, AnswersInvalidHttpWith400) {
  const RunningGateway gateway;
  EXPECT_THAT(http_exchange(gateway.port(), "\x16\x03\x01\x02 no words\r\n\r\n"),
              StartsWith("HTTP/1.1 400"));
}

TEST(GatewayConnection, AcceptsClientsDespiteManySilentConnections) {
  const RunningGateway gateway;
  std::vector<std::unique_ptr<SilentConnection>> silent;
  // More connections than the 32 without a WebSocket that the gateway keeps.
  for (int i = 0; i < 100; ++i) {
    silent.push_back(std::make_unique<SilentConnection>(gateway.port()));
  }
  const auto begin = std::chrono::steady_clock::now();
  ToolClient client(gateway.port());
  EXPECT_EQ(client.server_info()["op"], "serverInfo");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 4s) << "they are closed after 5 s";
}

TEST(GatewayConnection, SurvivesInvalidInput) {
  const RunningGateway gateway;
  {
    ToolClient client(gateway.port());
    for (const char* text : {"", "{", "[1]", "{\"op\":7}"}) client.web().send(text, true);
    client.web().send("\x7f\x01", false);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(client.next_text("status")["level"], 2);
    EXPECT_FALSE(client.web().has_ended()) << "a wrong message ends no connection";
    // An invalid WebSocket frame (reserved bits set, no mask) ends the connection.
    client.web().send_raw("\x7f\x7f\x7f\x7f");
    client.read_for(5s);
    EXPECT_TRUE(client.web().has_ended());
  }
  {
    ToolClient client(gateway.port());
    client.web().send(std::string(300'000, ' '), true);
    client.read_for(5s);
    EXPECT_TRUE(client.web().has_ended()) << "a message above 256 KiB";
  }
  EXPECT_THAT(http_exchange(gateway.port(), std::string(20'000, 'x') + "\r\n\r\n"),
              testing::Not(HasSubstr("200 OK")));
  ToolClient another(gateway.port());
  EXPECT_EQ(another.server_info()["op"], "serverInfo");
}

TEST(GatewayConnection, EndsAfterAFloodOfMessagesAndOtherConnectionsContinue) {
  const RunningGateway gateway;
  ToolClient calm(gateway.port());
  ToolClient flooding(gateway.port());
  // More than the permitted burst of 4,000, plus 200 for each second that sending takes.
  for (int i = 0; i < 20'000 && !flooding.web().has_ended(); ++i) {
    flooding.web().send(R"({"op":"unsubscribe","subscriptionIds":[]})", true);
  }
  EXPECT_TRUE(soon([&] {
    flooding.read_for(20ms);
    return flooding.web().has_ended();
  }));
  EXPECT_EQ(calm.server_info()["op"], "serverInfo");
  EXPECT_NO_THROW((void)calm.call("/read", {{"axis", "1.1"}, {"objects", {"0x6041"}}}));
}

// ---- topics

/// @return the name of the first member in which the axis and the message differ.
std::string difference(const client::AxisSnapshot& axis, const RosMessage& message,
                       std::size_t place) {
  for (const StatusMember& member : status_members()) {
    if (!member.is_published) continue;
    if (message.at(std::string(member.name)).at(place) != member.value(axis.status)) {
      return std::string(member.name);
    }
  }
  return {};
}

TEST(GatewayStatus, EqualsTheStatusOfTheSameLockstepRun) {
  const RunningService service("--clock lockstep");
  const RunningGateway gateway;
  Session session(options());
  auto axis = session.axis("1.1");
  ASSERT_TRUE(axis);
  ToolClient client(gateway.port());
  const std::string trace_topic = axis_topic(session, "/trace");
  const std::string status_topic = axis_topic(session, "/status");
  client.subscribe("/bench1/status");
  client.subscribe(status_topic);
  client.subscribe(trace_topic);
  // Once the first message is received, the gateway follows the bench.
  (void)client.next("/bench1/status");
  (void)client.next(status_topic);
  ASSERT_TRUE(axis->enable());
  ASSERT_TRUE(axis->move_by(500, {.velocity = 100'000}));

  std::vector<client::AxisSnapshot> expected;
  auto follower = session.follow({{1, 1}}, client::Pace::drive);
  ASSERT_TRUE(follower);
  for (int tick = 0; tick < 300; ++tick) {
    auto observation = follower->next(5s);
    ASSERT_TRUE(observation) << observation.outcome().message();
    expected.push_back(observation->axes[0]);
  }
  const std::uint64_t last = expected.back().tick;

  std::map<std::uint64_t, std::size_t> seen;
  bool has_last = false;
  while (!has_last) {
    const RosMessage trace = client.next_ros(trace_topic);
    EXPECT_EQ(trace.at("missed").at(0), 0);
    for (std::size_t i = 0; i < trace.at("tick").size(); ++i) {
      const auto tick = static_cast<std::uint64_t>(trace.at("tick")[i]);
      has_last = has_last || tick >= last;
      if (tick < expected.front().tick || tick > last) continue;
      ++seen[tick];
      EXPECT_EQ(difference(expected[tick - expected.front().tick], trace, i), "") << tick;
    }
  }
  EXPECT_EQ(seen.size(), expected.size()) << "every tick once";

  RosMessage status = client.next_ros(status_topic);
  while (static_cast<std::uint64_t>(status.at("tick")[0]) < last) {
    status = client.next_ros(status_topic);
  }
  EXPECT_EQ(difference(expected.back(), status, 0), "");
  EXPECT_EQ(static_cast<std::uint64_t>(status.at("owner_session")[0]), session.id());
  ChannelMessage bench = client.next("/bench1/status");
  // Drive time: ticks of a millisecond from 0.
  while (bench.time < last * 1'000'000) bench = client.next("/bench1/status");
  EXPECT_EQ(bench.time, last * 1'000'000);
  EXPECT_EQ(difference(expected.back(),
                       decode(client.channel("/bench1/status").at("schema"), bench.payload), 0),
            "");
}

TEST(GatewayStatus, SendsTheNewestSampleToASubscriberWhileTimeStandsStill) {
  const RunningService service("--clock lockstep");
  const RunningGateway gateway;
  for (int i = 0; i < 2; ++i) {
    ToolClient client(gateway.port());
    client.subscribe("/bench1/status");
    EXPECT_EQ(client.next_ros("/bench1/status").at("axis").size(), 2U);
    client.subscribe("/bench1/joint_states");
    EXPECT_FALSE(client.next("/bench1/joint_states").payload.empty());
  }
}

TEST(GatewayStatus, DescribesTheBenchAndItsState) {
  const RunningService service("--clock lockstep --axes 3");
  const RunningGateway gateway;
  ToolClient client(gateway.port());
  client.subscribe("/bench1/description");
  client.subscribe("/bench1/state");
  client.subscribe("/gateway/dictionary");
  client.subscribe("/gateway/control");
  const Json description = client.next_json("/bench1/description");
  EXPECT_EQ(description["clock_mode"], "lockstep");
  EXPECT_EQ(description["period_us"], 1000);
  ASSERT_EQ(description["axes"].size(), 3U);
  EXPECT_EQ(description["axes"][2]["axis"], 3);
  EXPECT_EQ(client.next_json("/bench1/state")["alive"], true);
  EXPECT_EQ(client.next_json("/gateway/dictionary")["objects"][0]["index"], "0x1000");
  const Json control = client.next_json("/gateway/control");
  EXPECT_EQ(control["enabled"], false);
  EXPECT_EQ(control["holder"], "");
}

TEST(GatewayStatus, AddsAndRemovesBenches) {
  const RunningGateway gateway;
  ToolClient client(gateway.port());
  {
    RunningService service("--clock realtime --bench 7");
    (void)client.channel("/bench7/status");
    client.subscribe("/bench7/state");
    EXPECT_EQ(client.next_json("/bench7/state")["bench"], 7);
    EXPECT_EQ(service.stop().code, 0);
  }
  EXPECT_TRUE(soon([&] {
    client.read_for(20ms);
    return !client.has_topic("/bench7/status");
  }));
}

TEST(GatewayStatus, HasNewTopicsForABenchThatReturnsWithOtherAxes) {
  const RunningGateway gateway;
  ToolClient client(gateway.port());
  RunningService before("--clock realtime --axes 2");
  client.subscribe("/bench1/state");
  client.subscribe("/bench1/description");
  client.subscribe("/bench1/events");
  EXPECT_EQ(client.next_json("/bench1/description")["axes"].size(), 2U);
  const Json known = client.channel("/bench1/status");
  before.kill();
  const RunningService after("--clock realtime --axes 5");
  EXPECT_TRUE(soon([&] {
    client.read_for(20ms);
    return client.has_topic("/bench1/status") &&
           client.channel("/bench1/status")["id"] != known["id"];
  }));
  client.subscribe("/bench1/description");
  EXPECT_EQ(client.next_json("/bench1/description")["axes"].size(), 5U);
}

TEST(GatewayStatus, ReportsASilentBench) {
  RunningService service("--clock realtime");
  const RunningGateway gateway;
  ToolClient client(gateway.port());
  client.subscribe("/bench1/state");
  EXPECT_EQ(client.next_json("/bench1/state")["alive"], true);
  service.kill();
  EXPECT_TRUE(soon([&] {
    return client.next_json("/bench1/state")["alive"] == false;
  }));
  const int age = client.next_json("/bench1/state")["age_ms"];
  EXPECT_TRUE(soon([&] {
    return client.next_json("/bench1/state")["age_ms"] > age;
  }));
}

TEST(GatewayStatus, SendsEventsAsLogAndTheTimeOfTheBench) {
  const RunningService service("--clock realtime");
  const RunningGateway gateway;
  Session session(options());
  auto axis = session.axis("1.1");
  ASSERT_TRUE(axis);
  ToolClient client(gateway.port());
  client.subscribe("/bench1/events");
  client.subscribe("/bench1/status");
  (void)client.next("/bench1/status");
  ASSERT_TRUE(axis->enable());
  const std::string name = axis_topic(session, "").substr(1);
  EXPECT_TRUE(soon([&] {
    return client.next("/bench1/events").payload.find(name) != std::string::npos;
  }));
  // In real time, a bench counts from the Unix epoch.
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const std::uint64_t time = client.next_text("time")["time"];
  EXPECT_NEAR(static_cast<double>(time) * 1e-9, std::chrono::duration<double>(now).count(), 30.0);
}

TEST(GatewayJudge, TellsWhatAMasterDoesWrongWhileSomebodyAsks) {
  const RunningService service("--clock realtime");
  Session session(options());
  auto axis = session.axis("1.2");
  ASSERT_TRUE(axis);
  const RunningGateway gateway;
  ToolClient client(gateway.port());
  (void)client.channel("/bench1/status");
  ASSERT_TRUE(axis->write({0x6060, 0}, 1));
  ASSERT_TRUE(axis->enable());
  const auto findings = [&] {
    const Json answer = client.call("/judge", {{"bench", 1}});
    EXPECT_TRUE(answer["ok"]) << answer;
    return answer["findings"];
  };
  EXPECT_TRUE(soon([&] {
    return client.call("/judge", {{"bench", 1}})["judged"] == true;
  }));
  EXPECT_EQ(findings(), Json::array()) << "it was enabled before";
  // A new target while bit 4 stays set.
  Json last;
  std::int64_t target = 100;
  EXPECT_TRUE(soon([&] {
    EXPECT_TRUE(axis->write({0x6040, 0}, 0x1F));
    EXPECT_TRUE(axis->write({0x607A, 0}, ++target));
    last = findings();
    return std::ranges::any_of(last, [](const Json& finding) {
      return finding["rule"] == "handshake-2" && finding["axis"] == 2 &&
             finding["severity"] == "error" && finding["tick"] > 0 && finding["count"] > 0;
    });
  })) << last;
  EXPECT_EQ(client.call("/judge", {{"bench", 9}})["ok"], true) << "it is searched for";
  EXPECT_TRUE(soon([&] {
    return client.call("/judge", {{"bench", 9}})["outcome"] == "not_found";
  }));
  EXPECT_THAT(client.call("/judge", Json::object())["message"], HasSubstr("'bench' is missing"));
}

TEST(GatewayStatus, HasTheEventsFromBeforeItsStartForEachClient) {
  const RunningService service("--clock realtime");
  Session session(options());
  auto axis = session.axis("1.2");
  ASSERT_TRUE(axis);
  ASSERT_TRUE(axis->enable());
  const RunningGateway gateway;
  for (int i = 0; i < 2; ++i) {
    ToolClient client(gateway.port());
    (void)client.channel("/bench1/status");
    EXPECT_TRUE(soon([&] {
      const Json answer = client.call("/events", {{"bench", 1}});
      return std::ranges::any_of(answer["events"], [](const Json& event) {
        return event["axis"] == 2 && event["kind"] == "state_changed" && event["level"] == 2 &&
               event["message"] == "axis 2: Operation enabled" && event["tick"] > 0;
      });
    }));
    EXPECT_EQ(client.call("/events", {{"bench", 9}})["events"], Json::array());
    EXPECT_THAT(client.call("/events", Json::object())["message"], HasSubstr("'bench' is missing"));
  }
}

TEST(GatewayMetrics, AreServedOnASeparatePort) {
  const RunningService service("--clock lockstep");
  RunningGateway gateway("--metrics 127.0.0.1:0");
  const std::string line = gateway.process().read_line();
  EXPECT_THAT(line, HasSubstr("/metrics"));
  const auto metrics_port = static_cast<std::uint16_t>(
      std::stoi(line.substr(line.find("127.0.0.1:") + std::string_view("127.0.0.1:").size())));
  const auto answer_to = [&](const std::string& request) {
    return http_exchange(metrics_port,
                         request + " HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  };
  (void)upgrade(gateway.port(), "mqtt", "");
  ToolClient client(gateway.port());
  client.subscribe("/bench1/status");
  (void)client.next("/bench1/status");
  EXPECT_TRUE(soon([&] {
    const std::string text = answer_to("GET /metrics?x=1");
    return text.find("HTTP/1.1 200") == 0 &&
           text.find("vdrive_gateway_clients 1\n") != std::string::npos &&
           text.find("vdrive_gateway_channels_subscribed 1\n") != std::string::npos &&
           text.find("_refused_total{reason=\"subprotocol\"} 1\n") != std::string::npos &&
           text.find("vdrive_gateway_bench_alive{bench=\"1\"} 1\n") != std::string::npos;
  })) << answer_to("GET /metrics");
  EXPECT_THAT(answer_to("GET /"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(answer_to("POST /metrics"), StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(upgrade(metrics_port, "foxglove.sdk.v1", ""), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(http_exchange(gateway.port(),
                            "GET /metrics HTTP/1.1\r\nHost: localhost\r\n"
                            "Connection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 404"))
      << "browsers and tools do not see them";
}

TEST(GatewayMetrics, AreRefusedForAUsedOrInvalidAddress) {
  const RunningGateway gateway;
  const std::string taken = "127.0.0.1:" + std::to_string(gateway.port());
  const Finished refused =
      Process(VDRIVE_GATEWAY, {"--listen", "127.0.0.1:0", "--metrics", taken}).wait();
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("cannot listen on 127.0.0.1 port"));
  const Finished wrong = Process(VDRIVE_GATEWAY, {"--metrics", "9100"}).wait();
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("--metrics '9100'"));
}

TEST(GatewayOptions, NameValueAndLimitsOfANumber) {
  const Finished wrong = Process(VDRIVE_GATEWAY, {"--clients", "1e9"}).wait();
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("--clients: '1e9' must be a whole number from 1 to 1000"));
}

// ---- the graph of connections

/// @return the identifiers listed for this name.
Json ids_of(const Json& list, const std::string& name, const char* key) {
  for (const Json& entry : list) {
    if (entry["name"] == name) return entry[key];
  }
  return nullptr;
}

TEST(GatewayGraph, NamesPublishersAndReceiversOfATopic) {
  const RunningService service("--clock lockstep");
  const RunningGateway gateway;
  ToolClient watcher(gateway.port());
  ToolClient receiver(gateway.port());
  (void)watcher.channel("/bench1/status");
  watcher.send({{"op", "subscribeConnectionGraph"}});
  const Json graph = watcher.next_text("connectionGraphUpdate");
  EXPECT_EQ(ids_of(graph["publishedTopics"], "/bench1/status", "publisherIds"),
            Json::array({"bench1"}));
  EXPECT_EQ(ids_of(graph["subscribedTopics"], "/bench1/status", "subscriberIds"), Json::array());
  EXPECT_EQ(ids_of(graph["advertisedServices"], "/move", "providerIds"), Json::array({"gateway"}));
  const auto becomes = [&](std::size_t receivers) {
    return soon([&] {
      const Json update = watcher.next_text("connectionGraphUpdate");
      return ids_of(update["subscribedTopics"], "/bench1/status", "subscriberIds").size() ==
             receivers;
    });
  };
  receiver.subscribe("/bench1/status");
  EXPECT_TRUE(becomes(1));
  receiver.web().close();
  EXPECT_TRUE(becomes(0));
}

// ---- parameters

TEST(GatewayParameters, ReadWriteAndReportChanges) {
  const RunningService service("--clock realtime");
  const RunningGateway gateway("--control");
  Session session(options());
  const std::string velocity = parameter(session, "0x6081");
  const std::string read_only = parameter(session, "0x6064");
  ToolClient client(gateway.port());
  (void)client.channel("/bench1/status");
  client.send({{"op", "getParameters"}, {"parameterNames", Json::array()}, {"id", "all"}});
  const Json all = client.next_text("parameterValues");
  EXPECT_EQ(all["id"], "all");
  EXPECT_GT(all["parameters"].size(), 150U) << "two axes of more than 90 objects";
  client.send({{"op", "subscribeParameterUpdates"}, {"parameterNames", {velocity}}});
  EXPECT_EQ(client.next_text("parameterValues")["parameters"][0]["name"], velocity);

  const Json change{{"op", "setParameters"},
                    {"parameters", Json::array({{{"name", velocity}, {"value", 12'345}}})},
                    {"id", "set"}};
  client.send(change);
  EXPECT_THAT(client.next_text("status")["message"], HasSubstr("/take_control"));
  EXPECT_EQ(client.call("/take_control", {{"name", "test"}})["ok"], true);
  client.send(change);
  bool is_answered = false;
  bool is_reported = false;
  EXPECT_TRUE(soon([&] {
    const Json values = client.next_text("parameterValues");
    EXPECT_EQ(values["parameters"][0]["value"], 12'345);
    (values.contains("id") ? is_answered : is_reported) = true;
    return is_answered && is_reported;
  }));
  EXPECT_EQ(*session.axis("1.1")->read({0x6081, 0}), 12'345);

  client.send({{"op", "setParameters"},
               {"parameters", Json::array({{{"name", read_only}, {"value", 1}}})}});
  const Json refusal = client.next_text("status");
  EXPECT_EQ(refusal["level"], 2);
  EXPECT_THAT(refusal["message"], HasSubstr(read_only + " = 1"));
  EXPECT_THAT(refusal["message"], HasSubstr("0x06010002"));
}

// ---- commands

TEST(GatewayServices, CommandNothingWithoutControl) {
  const RunningService service("--clock realtime");
  const RunningGateway observing;
  ToolClient client(observing.port());
  (void)client.channel("/bench1/status");
  for (const char* name : {"/take_control", "/enable", "/halt", "/quick_stop"}) {
    const Json answer = client.call(name, {{"axes", {"1.1"}}});
    EXPECT_EQ(answer["ok"], false) << name;
    EXPECT_THAT(answer["message"], HasSubstr("--control")) << name;
  }
  const Json read = client.call("/read", {{"axis", "1.1"}, {"objects", {"0x6041", "0x6502"}}});
  EXPECT_EQ(read["ok"], true);
  EXPECT_EQ(read["values"].size(), 2U);
}

TEST(GatewayServices, EnableMoveAndStopAnAxis) {
  const RunningService service("--clock realtime");
  const RunningGateway gateway("--control");
  Session session(options());
  auto axis = session.axis("1.1");
  ASSERT_TRUE(axis);
  ToolClient client(gateway.port());
  (void)client.channel("/bench1/status");
  EXPECT_THAT(client.call("/enable", {{"axes", {"1.1"}}})["message"],
              HasSubstr("take control first"));
  ASSERT_EQ(client.call("/take_control", Json::object())["ok"], true);
  ASSERT_EQ(client.call("/enable", {{"axes", {"1.1", "1.2"}}})["message"], "");
  EXPECT_EQ(axis->status()->state(), PowerState::operation_enabled);
  ASSERT_EQ(
      client.call("/move", {{"axis", "1.1"}, {"position", 4096}, {"velocity", 40'000}})["message"],
      "");
  EXPECT_TRUE(axis->wait_until(
      [](const auto& status) {
        return status.status.load_position_actual_value == 4096;
      },
      20s));
  EXPECT_EQ(client.call("/jog", {{"axis", "1.1"}, {"velocity", 1000}})["message"], "");
  // The jog is not repeated, so the gateway ends it after 400 ms.
  EXPECT_TRUE(axis->wait_until(
      [](const auto& status) {
        return status.status.velocity_demand_value == 1000;
      },
      10s));
  EXPECT_TRUE(axis->wait_until(
      [](const auto& status) {
        return status.status.velocity_demand_value == 0;
      },
      10s));
  EXPECT_EQ(client.call("/write", {{"axis", "1.1"}, {"object", "0x6081"}, {"value", 77}})["ok"],
            true);
  EXPECT_EQ(*axis->read({0x6081, 0}), 77);
  const Json named = client.call("/read", {{"axis", "1.1"}, {"objects", {"profile_velocity"}}});
  EXPECT_EQ(named["values"][0]["object"], "0x6081");
  EXPECT_EQ(named["values"][0]["value"], 77);
  EXPECT_EQ(client.call("/quick_stop", Json::object())["message"], "");
  EXPECT_TRUE(axis->wait_until(
      [](const auto& status) {
        return status.state() != PowerState::operation_enabled;
      },
      10s));
}

// As if a page had been closed while its axes were in mode 3. A single axis and several axes take
// different paths in the code.
TEST(GatewayServices, EnableLetsAxesRestWhateverWasLeft) {
  const RunningService service("--clock lockstep --axes 2");
  const RunningGateway gateway("--control");
  Session session(options());
  ToolClient client(gateway.port());
  (void)client.channel("/bench1/status");
  ASSERT_EQ(client.call("/take_control", Json::object())["ok"], true);
  for (const Json& axes : {Json::array({"1.1"}), Json::array({"1.1", "1.2"})}) {
    for (const Json& axis : axes) {
      for (const auto& [object, value] : {std::pair{"0x6060", 3}, std::pair{"0x60FF", 2048}}) {
        const Json request{{"axis", axis}, {"object", object}, {"value", value}};
        ASSERT_EQ(client.call("/write", request)["message"], "");
      }
    }
    ASSERT_EQ(client.call("/enable", {{"axes", axes}})["message"], "");
    ASSERT_TRUE(session.step(1, 300));
    for (const Json& axis : axes) {
      const auto seen = session.axis(axis.get<std::string>())->status();
      EXPECT_EQ(seen->state(), PowerState::operation_enabled);
      EXPECT_EQ(seen->status.velocity_demand_value, 0);
    }
    ASSERT_EQ(client.call("/disable", {{"axes", axes}})["message"], "");
  }
}

TEST(GatewayServices, ServeTheButtonsOfADashboard) {
  const TemporaryDirectory state;
  // With a long watchdog time, for busy machines.
  const RunningService service("--clock realtime --axes 2 --config " VDRIVE_SOURCE_DIR
                               "/tests/data/patient.yaml --state " +
                               state.path().string());
  const RunningGateway gateway("--control");
  Session session(options());
  auto axis = session.axis("1.1");
  ASSERT_TRUE(axis);
  ToolClient client(gateway.port());
  (void)client.channel("/bench1/status");
  ASSERT_EQ(client.call("/take_control", Json::object())["ok"], true);
  const Json first{{"axes", {"1.1"}}};
  const Json both{{"axes", {"1.1", "1.2"}}};
  const auto is_done = [&](const char* name, const Json& request) {
    const Json answer = client.call(name, request);
    return answer["ok"] == true ? std::string() : name + answer.dump();
  };
  EXPECT_EQ(is_done("/enable", both), "");
  EXPECT_EQ(is_done("/move", {{"axis", "1.1"}, {"position", 100'000}, {"velocity", 2'000}}), "");
  EXPECT_EQ(is_done("/halt", first), "");
  EXPECT_EQ(is_done("/resume", first), "");
  EXPECT_EQ(is_done("/move", {{"axis", "1.1"}, {"position", -300}, {"relative", true}}), "");
  EXPECT_EQ(is_done("/quick_stop", {{"bench", 1}}), "");
  EXPECT_EQ(is_done("/disable", both), "");
  EXPECT_EQ(is_done("/enable", both), "");
  const Json moves =
      Json::array({{{"axis", "1.1"}, {"position", 900}}, {{"axis", "1.2"}, {"position", -900}}});
  EXPECT_EQ(
      is_done("/move_group", {{"moves", moves}, {"velocity", 50'000}, {"acceleration", 1'000'000}}),
      "");
  EXPECT_TRUE(axis->wait_until(
      [](const auto& status) {
        return status.status.load_position_actual_value == 900;
      },
      20s));
  EXPECT_EQ(*axis->read({0x6083, 0}), 1'000'000);
  EXPECT_EQ(is_done("/home", {{"axis", "1.1"}}), "");
  // The answer is sent when homing starts; a second start is ignored until the first run ends.
  EXPECT_TRUE(axis->wait_until(
      [](const auto& status) {
        return status.mode() == OperatingMode::homing && status.shows(Statusword::kTargetReached) &&
               status.shows(Statusword::kHomingAttained);
      },
      20s));
  EXPECT_EQ(is_done("/home", {{"axis", "1.1"}, {"method", 37}}), "");
  EXPECT_EQ(*axis->read({0x6098, 0}), 37);
  EXPECT_EQ(is_done("/disturb", {{"axis", "1.1"}, {"name", "over_current"}, {"value", 1}}), "");
  EXPECT_TRUE(axis->wait_until(
      [](const auto& status) {
        return status.state() == PowerState::fault;
      },
      20s));
  EXPECT_EQ(is_done("/end_disturbances", both), "");
  EXPECT_EQ(is_done("/reset", first), "");
  EXPECT_EQ(is_done("/disable", both), "");
  EXPECT_EQ(is_done("/store", both), "");
  EXPECT_EQ(is_done("/restore", first), "");
  EXPECT_EQ(is_done("/power_cycle", first), "");
  EXPECT_NE(*axis->read({0x6083, 0}), 1'000'000) << "the default is in force again";
  EXPECT_EQ(is_done("/rate", {{"bench", 1}, {"rate", 2.5}}), "");
  EXPECT_EQ(is_done("/pause", {{"bench", 1}}), "");
}

TEST(GatewayServices, StepALockstepBench) {
  const RunningService service("--clock lockstep");
  const RunningGateway gateway("--control");
  ToolClient client(gateway.port());
  (void)client.channel("/bench1/status");
  ASSERT_EQ(client.call("/take_control", Json::object())["ok"], true);
  EXPECT_EQ(client.call("/step", {{"bench", 1}, {"ticks", 250}})["tick"], 250);
  EXPECT_EQ(client.call("/step", {{"bench", 1}, {"ticks", 1}})["tick"], 251);
  EXPECT_THAT(client.call("/step", {{"bench", 1}, {"ticks", 0}})["message"], HasSubstr("1000000"));
}

TEST(GatewayServices, FreezeTheTicksUpToNowForAProgramWithControl) {
  const RunningService service("--clock lockstep");
  const RunningGateway gateway("--control");
  ToolClient client(gateway.port());
  (void)client.channel("/bench1/status");
  EXPECT_THAT(client.call("/freeze", {{"bench", 1}})["message"], HasSubstr("control"));
  ASSERT_EQ(client.call("/take_control", Json::object())["ok"], true);
  ASSERT_EQ(client.call("/step", {{"bench", 1}, {"ticks", 40}})["tick"], 40);
  EXPECT_THAT(client.call("/freeze", Json::object())["message"], HasSubstr("'bench'"));
  const Json frozen = client.call("/freeze", {{"bench", 1}});
  ASSERT_EQ(frozen["window"], 1) << frozen;
  const Json window = client.call("/fault", {{"window", 1}, {"axis", "1.1"}});
  const auto& ticks = window["samples"]["tick"];
  ASSERT_EQ(ticks.size(), 41U) << window["message"];  // 0 to 40: none is older than the bench
  EXPECT_EQ(ticks.front(), 0);
  EXPECT_EQ(window["samples"]["ds402_statusword"].size(), 41U);
}

TEST(GatewayServices, DescribeTheErrorOfARequest) {
  const RunningService service("--clock realtime");
  const RunningGateway gateway("--control");
  ToolClient client(gateway.port());
  (void)client.channel("/bench1/status");
  ASSERT_EQ(client.call("/take_control", Json::object())["ok"], true);
  EXPECT_THAT(client.call("/move", {{"axis", "1.1"}})["message"], HasSubstr("'position'"));
  EXPECT_THAT(client.call("/move", {{"axis", "1.1"}, {"position", 3e9}})["message"],
              HasSubstr("2147483647"));
  EXPECT_THAT(client.call("/enable", {{"axes", "1.1"}})["message"], HasSubstr("list"));
  EXPECT_EQ(client.call("/enable", {{"axes", {"1.9"}}})["outcome"], "not_found");
  EXPECT_THAT(client.call("/take_control", Json::array())["failure"], HasSubstr("object"));
}

/// A gateway that offers control, and a separate session that observes axis 1.1.
class GatewayControl : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(axis_) << axis_.outcome().message(); }

 private:
  const RunningService service_{"--clock realtime"};

 protected:
  RunningGateway gateway_{"--control"};

 private:
  Session session_{options()};

 protected:
  client::Result<client::Axis> axis_ = session_.axis("1.1");
};

TEST_F(GatewayControl, RefusesAVelocityOfAGroupThatAnAxisDoesNotReach) {
  ToolClient client(gateway_.port());
  (void)client.channel("/bench1/status");
  ASSERT_EQ(client.call("/take_control", Json::object())["ok"], true);
  ASSERT_EQ(client.call("/enable", {{"axes", {"1.1", "1.2"}}})["ok"], true);
  const std::int64_t highest = *axis_->read({0x607F, 0});
  const std::int64_t before = *axis_->read({0x6081, 0});
  const Json moves =
      Json::array({{{"axis", "1.1"}, {"position", 900}}, {{"axis", "1.2"}, {"position", -900}}});
  const Json answer = client.call(
      "/move_group", {{"moves", moves}, {"velocity", highest + 1}, {"acceleration", 7}});
  EXPECT_EQ(answer["outcome"], "refused");
  EXPECT_THAT(answer["message"],
              HasSubstr("axis 1.1: the velocity " + std::to_string(highest + 1) + " UU/s ("));
  EXPECT_EQ(*axis_->read({0x6081, 0}), before) << "nothing is written";
  EXPECT_NE(*axis_->read({0x6083, 0}), 7);
  EXPECT_EQ(client.call("/move_group", {{"moves", moves}, {"velocity", highest}})["ok"], true);
}

TEST_F(GatewayControl, IsHeldByOneConnection) {
  ToolClient first(gateway_.port());
  ToolClient second(gateway_.port());
  (void)first.channel("/bench1/status");
  (void)second.channel("/bench1/status");
  ASSERT_EQ(first.call("/take_control", {{"name", "first"}})["ok"], true);
  EXPECT_THAT(second.call("/take_control", Json::object())["message"], HasSubstr("'first'"));
  EXPECT_THAT(second.call("/enable", {{"axes", {"1.1"}}})["message"], HasSubstr("'first'"));
  ASSERT_EQ(first.call("/enable", {{"axes", {"1.1"}}})["message"], "");
  EXPECT_EQ(second.call("/halt", {{"axes", {"1.1"}}})["message"], "") << "anybody may stop";
  second.subscribe("/gateway/control");
  EXPECT_EQ(second.next_json("/gateway/control")["holder"], "first");
  ASSERT_EQ(second.call("/take_control", {{"name", "second"}, {"force", true}})["ok"], true);
  const Json control = second.next_json("/gateway/control");
  EXPECT_EQ(control["holder"], "second");
  EXPECT_EQ(control["you"], true);
  EXPECT_THAT(first.call("/enable", {{"axes", {"1.1"}}})["message"], HasSubstr("'second'"));
}

/// Expects the axis to have no owner and to stay as it is.
void expect_released(client::Axis& axis) {
  EXPECT_TRUE(axis.wait_until(
      [](const auto& status) {
        return status.owner_session == 0;
      },
      10s));
  EXPECT_EQ(axis.status()->state(), PowerState::operation_enabled);
}

/// Takes control and enables an axis.
void command(ToolClient& client) {
  (void)client.channel("/bench1/status");
  ASSERT_EQ(client.call("/take_control", Json::object())["ok"], true);
  ASSERT_EQ(client.call("/enable", {{"axes", {"1.1"}}})["message"], "");
}

TEST_F(GatewayControl, IsReleasedByAGracefulClose) {
  ToolClient client(gateway_.port());
  command(client);
  EXPECT_NE(axis_->status()->owner_session, 0U);
  client.web().close();
  expect_released(*axis_);
}

// Released without the fault that 10 s of silence would cause.
TEST_F(GatewayControl, IsReleasedByACloseWithoutACode) {
  ToolClient client(gateway_.port());
  command(client);
  // A close frame without payload, masked with zeros, as sent by WebSocket.close() in browsers.
  client.web().send_raw({"\x88\x80\0\0\0\0", 6});
  client.read_for(1s);  // the gateway answers it, and each side ends its connection
  expect_released(*axis_);
}

void expect_lost_master(client::Axis& axis) {
  const auto fault = axis.wait_until(
      [](const auto& status) {
        return status.state() == PowerState::fault;
      },
      30s);
  ASSERT_TRUE(fault) << fault.outcome().message();
  EXPECT_EQ(fault->status.error_code, kLostMaster);
}

TEST_F(GatewayControl, IsLostWithASilentConnection) {
  ToolClient client(gateway_.port());
  command(client);
  // The client does not read, so it does not answer pings.
  expect_lost_master(*axis_);
}

TEST_F(GatewayControl, IsLostSoonerAfterAShorterSilenceThatTheHolderChose) {
  ToolClient client(gateway_.port());
  command(client);
  EXPECT_THAT(client.call("/take_control", {{"silence_ms", 500}})["failure"],
              HasSubstr("from 1000 to 10000"));
  ASSERT_EQ(client.call("/take_control", {{"silence_ms", 1'000}})["ok"], true);
  const auto begin = std::chrono::steady_clock::now();
  expect_lost_master(*axis_);
  // 1 s of silence, up to 0.25 s until the gateway checks, and 0.5 s of the bench's watchdog.
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 8s) << "not the 10 s of a holder by default";
}

TEST_F(GatewayControl, IsLostWithABrokenConnection) {
  {
    ToolClient client(gateway_.port());
    command(client);
  }
  expect_lost_master(*axis_);
}

TEST_F(GatewayControl, IsLostWithTheGateway) {
  ToolClient client(gateway_.port());
  command(client);
  gateway_.process().send(SIGKILL);
  expect_lost_master(*axis_);
}

TEST_F(GatewayControl, IsReleasedAtTheEndOfTheGateway) {
  ToolClient client(gateway_.port());
  command(client);
  gateway_.process().send(SIGTERM);
  client.read_for(500ms);
  EXPECT_EQ(gateway_.process().wait().code, 0);
  expect_released(*axis_);
}

// ---- slow clients

TEST(GatewayQueues, DropTheOldestForASlowClientAndReportIt) {
  const RunningService service("--clock realtime --axes 256");
  const RunningGateway gateway("--rate 500");
  ToolClient slow(WebOptions{.port = gateway.port(), .receive_buffer = 65'536});
  ToolClient quick(gateway.port());
  slow.subscribe("/bench1/status");
  quick.subscribe("/bench1/status");
  (void)slow.next("/bench1/status");
  // 256 axes of 93 bytes at 500 Hz: 12 MB/s fill the queue and the socket buffers within a second.
  const auto deadline = std::chrono::steady_clock::now() + 3s;
  int received = 0;
  while (std::chrono::steady_clock::now() < deadline) {
    (void)quick.next("/bench1/status");
    ++received;
  }
  EXPECT_GT(received, 50) << "the other clients continue";
  const Json warning = slow.next_text("status");
  EXPECT_EQ(warning["level"], 1);
  EXPECT_THAT(warning["message"], HasSubstr("dropped"));
}

}  // namespace
}  // namespace vdrive::test

// SPDX-License-Identifier: Apache-2.0
// Control, service calls and parameters, without a network or a bench.
#include "control_desk.hpp"

#include "client_table.hpp"
#include "gateway/recorded_server.hpp"
#include "parameter_desk.hpp"
#include "service_calls.hpp"
#include "web_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::gateway {
namespace {

using client::Outcome;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr ConnectionId kFirst = 1;
constexpr ConnectionId kSecond = 2;

/// Two open connections and a desk whose sessions are numbers: 100, 101, ...
class ControlOfAGateway : public testing::Test, public BenchAccess {
 protected:
  ControlOfAGateway() {
    clients_.open(kFirst);
    clients_.open(kSecond);
    for (const ConnectionId id : {kFirst, kSecond}) desk_.channel()->receivers.push_back({id, 1});
  }

  /// Ends the jobs of connections before the members that they use are destroyed.
  void TearDown() override {
    clients_.close(kFirst);
    clients_.close(kSecond);
    clients_.join_ended();
  }

  HeldSession open() override {
    if (!error_.empty()) throw std::runtime_error(error_);
    return {.id = next_session_++, .session = {}, .jogs = {}};
  }

  void end(HeldSession held, bool is_graceful) override {
    ended_.push_back(std::to_string(held.id) + (is_graceful ? " released" : " abandoned"));
  }

  CallAnswer call(const ServiceRow& /*row*/, const SessionPointer& /*own*/,
                  const Json& /*request*/) override {
    return {};
  }

  ParameterAnswer read(const BenchList& /*benches*/,
                       const std::vector<std::string>& /*names*/) override {
    return {};
  }

  ParameterAnswer write(const SessionPointer& /*own*/, const BenchList& /*benches*/,
                        const std::vector<ParameterChange>& /*changes*/) override {
    return {};
  }

  /// @return the message in the answer to /take_control; empty = the connection has control.
  std::string take(ConnectionId id, const Json& request = Json::object()) {
    std::string message = "no answer";
    desk_.take(id, request, [&](const CallAnswer& answer) {
      message = answer.outcome.message();
    });
    if (message == "no answer") {
      EXPECT_TRUE(server_.run()) << "the session is open";
    }
    return message;
  }

  /// @return the latest message of the topic on this connection.
  Json shown(ConnectionId id) { return server_.take_json(id).back(); }

  RecordedServer server_;
  ClientTable clients_;
  std::string error_;
  std::atomic<std::uint64_t> next_session_ = 100;  ///< used by the threads of all connections
  std::vector<std::string> ended_;
  ControlDesk desk_{true, *this, server_, clients_};
};

TEST_F(ControlOfAGateway, LetsOneConnectionCommand) {
  EXPECT_THAT(desk_.check(kFirst, Right::command).message(), HasSubstr("take control first"));
  EXPECT_EQ(take(kFirst), "");
  EXPECT_TRUE(desk_.is_held());
  EXPECT_TRUE(desk_.check(kFirst, Right::command));
  EXPECT_TRUE(desk_.check(kFirst, Right::jog));
  EXPECT_THAT(desk_.check(kSecond, Right::command).message(), HasSubstr("held by 'client 1'"));
}

TEST_F(ControlOfAGateway, LetsEverybodyReadAndStop) {
  for (const Right right : {Right::none, Right::events, Right::judge, Right::stop,
                            Right::take_control, Right::release_control}) {
    EXPECT_TRUE(desk_.check(kFirst, right)) << static_cast<int>(right);
  }
}

TEST_F(ControlOfAGateway, RefusesAllButReadingWhereTheGatewayIsViewOnly) {
  ControlDesk viewing(false, *this, server_, clients_);
  EXPECT_TRUE(viewing.check(kFirst, Right::none));
  for (const Right right : {Right::stop, Right::command, Right::jog, Right::take_control}) {
    EXPECT_THAT(viewing.check(kFirst, right).message(), HasSubstr("view-only"));
  }
}

TEST_F(ControlOfAGateway, ShowsEachReceiverWhoHasControl) {
  EXPECT_EQ(take(kFirst, {{"name", "lab\nroom"}}), "");
  const Json own = shown(kFirst);
  EXPECT_EQ(own["holder"], R"(lab\nroom)") << "on one line";
  EXPECT_EQ(own["you"], true);
  EXPECT_EQ(own["session"], "0x0000000000000064");  // 100
  const Json other = shown(kSecond);
  EXPECT_EQ(other["you"], false);
  EXPECT_EQ(other["name"], "client 2");
  desk_.release(kFirst);
  EXPECT_EQ(shown(kSecond)["holder"], "");
}

TEST_F(ControlOfAGateway, TakesOverOnlyByForceAndTellsTheHolderByWhom) {
  EXPECT_EQ(take(kFirst), "");
  EXPECT_THAT(take(kSecond), HasSubstr("call /take_control with force to take it over"));
  EXPECT_THAT(ended_, IsEmpty());
  (void)server_.take(kFirst);
  EXPECT_EQ(take(kSecond, {{"force", true}, {"name", "night shift"}}), "");
  EXPECT_THAT(ended_, ElementsAre("100 released"));
  EXPECT_THAT(server_.take_json(kFirst).front()["message"], HasSubstr("'night shift'"));
  EXPECT_TRUE(desk_.check(kSecond, Right::command));
  EXPECT_FALSE(desk_.check(kFirst, Right::command));
}

TEST_F(ControlOfAGateway, RefusesTheSlowerOfTwoThatTakeControlAtOnce) {
  std::vector<std::string> answers;
  const auto note = [&](const CallAnswer& answer) {
    answers.push_back(answer.outcome.message());
  };
  desk_.take(kFirst, Json::object(), note);
  desk_.take(kSecond, Json::object(), note);
  ASSERT_TRUE(server_.run(2));
  ASSERT_THAT(answers, SizeIs(2));
  EXPECT_EQ(std::ranges::count(answers, ""), 1);
  EXPECT_THAT(answers.back(), HasSubstr("control is held by"));
  EXPECT_THAT(ended_, IsEmpty()) << "the session of the slower one has held nothing";
}

TEST_F(ControlOfAGateway, RenamesAHolderThatTakesControlAgain) {
  EXPECT_EQ(take(kFirst), "");
  EXPECT_EQ(take(kFirst, {{"name", "lab"}}), "");
  EXPECT_EQ(shown(kSecond)["holder"], "lab");
  EXPECT_EQ(next_session_, 101U) << "it keeps its session";
}

TEST_F(ControlOfAGateway, AnswersWithTheErrorOfTheSession) {
  error_ = "no network";
  EXPECT_EQ(take(kFirst), "no network");
  EXPECT_FALSE(desk_.is_held());
}

TEST_F(ControlOfAGateway, GivesAxesBackAtAGracefulCloseAndAbandonsThemWithALostConnection) {
  EXPECT_EQ(take(kFirst), "");
  desk_.close(kSecond, false);
  EXPECT_TRUE(desk_.is_held()) << "another connection was lost";
  desk_.close(kFirst, true);
  EXPECT_EQ(take(kSecond), "");
  desk_.close(kSecond, false);
  EXPECT_THAT(ended_, ElementsAre("100 released", "101 abandoned"));
}

TEST_F(ControlOfAGateway, ForgetsASessionWhoseConnectionHasClosed) {
  bool is_answered = false;
  desk_.take(kFirst, Json::object(), [&](const CallAnswer&) {
    is_answered = true;
  });
  // The session is open; its action waits for the server thread.
  ASSERT_TRUE(server_.await());
  desk_.channel()->receivers.clear();
  EXPECT_TRUE(clients_.close(kFirst));
  desk_.close(kFirst, true);
  ASSERT_TRUE(server_.run());
  EXPECT_FALSE(is_answered);
  EXPECT_FALSE(desk_.is_held());
}

TEST_F(ControlOfAGateway, ExpectsAHolderToBeReachableSooner) {
  EXPECT_EQ(take(kFirst), "");
  EXPECT_LT(server_.patience().at(kFirst).machine, WebServer::kPatience.machine);
  EXPECT_EQ(server_.patience().at(kFirst).program, WebServer::kPatience.program);
  desk_.release(kFirst);
  EXPECT_EQ(server_.patience().at(kFirst).machine, WebServer::kPatience.machine);
}

TEST_F(ControlOfAGateway, LetsTheHolderChooseHowLongItMayBeSilent) {
  EXPECT_EQ(take(kFirst, {{"silence_ms", 1'500}}), "");
  EXPECT_EQ(server_.patience().at(kFirst).program, std::chrono::milliseconds(1'500));
  EXPECT_EQ(server_.patience().at(kFirst).machine, std::chrono::milliseconds(1'500))
      << "a cut network is noticed no later than a program that stands still";
  EXPECT_EQ(shown(kSecond)["silence_ms"], 1'500);
  EXPECT_EQ(take(kFirst, {{"silence_ms", 5'000}}), "");
  EXPECT_EQ(server_.patience().at(kFirst).program, std::chrono::milliseconds(5'000));
  EXPECT_EQ(server_.patience().at(kFirst).machine, std::chrono::milliseconds(2'000));
  EXPECT_EQ(shown(kSecond)["silence_ms"], 5'000);
  EXPECT_EQ(take(kFirst, {{"name", "lab"}}), "");
  EXPECT_EQ(shown(kSecond)["silence_ms"], 5'000) << "another name leaves the limit";
  EXPECT_EQ(next_session_, 101U) << "it keeps its session";
  desk_.release(kFirst);
  EXPECT_EQ(server_.patience().at(kFirst).program, WebServer::kPatience.program);
  EXPECT_EQ(shown(kSecond)["silence_ms"], 0);
}

TEST_F(ControlOfAGateway, RefusesALimitOfSilenceThatIsTooShortOrTooLong) {
  EXPECT_EQ(take(kFirst), "");
  for (const int silence : {999, 10'001, 0, -1}) {
    try {
      (void)take(kFirst, {{"silence_ms", silence}});
      FAIL() << silence;
    } catch (const ProtocolError& error) {
      EXPECT_THAT(error.what(),
                  HasSubstr("'silence_ms' must be a number from 1000 to 10000, not '" +
                            std::to_string(silence) + "'"));
    }
  }
  EXPECT_EQ(server_.patience().at(kFirst).program, WebServer::kPatience.program);
  for (const int silence : {1'000, 10'000}) {
    EXPECT_EQ(take(kFirst, {{"silence_ms", silence}}), "");
    EXPECT_EQ(server_.patience().at(kFirst).program, std::chrono::milliseconds(silence));
  }
}

// ---- service calls

/// @return the number of a service in the protocol.
std::uint32_t number_of_service(std::string_view name) {
  const auto rows = services();
  const auto row = std::ranges::find(rows, name, &ServiceRow::name);
  return static_cast<std::uint32_t>(row - rows.begin()) + 1;
}

class CallsOfServices : public ControlOfAGateway {
 protected:
  void TearDown() override {
    release_.set_value();
    ControlOfAGateway::TearDown();
  }

  /// Answers with the name of the service; /move waits for the end of the test.
  CallAnswer call(const ServiceRow& row, const SessionPointer& /*own*/,
                  const Json& request) override {
    if (request.contains("wrong")) throw ProtocolError("'wrong' is wrong");
    if (row.name == "/move") released_.wait();
    return {.outcome = {}, .fields = {{"service", row.name}}};
  }

  void send(ConnectionId id, std::string_view service, const std::string& payload,
            const std::string& encoding = "json") {
    calls_.handle(id, {.service = number_of_service(service),
                       .call = 5,
                       .encoding = encoding,
                       .payload = payload});
  }

  std::promise<void> release_;
  std::shared_future<void> released_{release_.get_future()};
  ServiceCalls calls_{*this, server_, clients_, desk_};
};

TEST_F(CallsOfServices, AnswerWithWhatTheServiceDid) {
  send(kFirst, "/read", "{}");
  ASSERT_TRUE(server_.run());
  const auto sent = server_.take_json(kFirst);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0]["service"], "/read");
  EXPECT_EQ(sent[0]["ok"], true);
}

TEST_F(CallsOfServices, AnswerARefusalAtOnce) {
  send(kFirst, "/move", "{}");
  const auto sent = server_.take_json(kFirst);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_THAT(std::string(sent[0]["message"]), HasSubstr("take control first"));
}

TEST_F(CallsOfServices, FailWithTheReasonWhereTheCallItselfIsWrong) {
  calls_.handle(kFirst, {.service = 99, .call = 5, .encoding = "json", .payload = "{}"});
  send(kFirst, "/read", "{}", "xml");
  send(kFirst, "/read", "[]");
  const auto sent = server_.take_json(kFirst);
  ASSERT_THAT(sent, SizeIs(3));
  EXPECT_EQ(sent[0]["op"], "serviceCallFailure");
  EXPECT_EQ(sent[0]["message"], "service 99 does not exist");
  EXPECT_THAT(std::string(sent[1]["message"]), HasSubstr("'xml'"));
  EXPECT_EQ(sent[2]["message"], "the request is not a JSON object");
}

TEST_F(CallsOfServices, AnswerAWrongRequestWithItsReason) {
  send(kFirst, "/read", R"({"wrong": 1})");
  ASSERT_TRUE(server_.run());
  const auto sent = server_.take_json(kFirst);
  EXPECT_EQ(sent.at(0)["outcome"], "failed");
  EXPECT_EQ(sent.at(0)["message"], "'wrong' is wrong");
}

TEST_F(CallsOfServices, StopDuringACallThatWaits) {
  EXPECT_EQ(take(kFirst), "");
  (void)server_.take(kFirst);
  send(kFirst, "/move", "{}");
  send(kFirst, "/quick_stop", "{}");
  ASSERT_TRUE(server_.run());
  EXPECT_EQ(server_.take_json(kFirst).at(0)["service"], "/quick_stop");
}

TEST_F(CallsOfServices, AreDroppedWithAnAnswerWhenTooManyWait) {
  EXPECT_EQ(take(kFirst), "");
  (void)server_.take(kFirst);
  // One call is in progress, and kMostJobs calls may wait.
  for (std::size_t i = 0; i < bridge::Worker::kMostJobs + 2; ++i) send(kFirst, "/move", "{}");
  const auto sent = server_.take_json(kFirst);
  ASSERT_FALSE(sent.empty());
  EXPECT_EQ(sent.back()["message"], "too many calls are waiting: this one was dropped");
}

TEST_F(CallsOfServices, TakeAndReleaseControl) {
  send(kFirst, "/take_control", "{}");
  ASSERT_TRUE(server_.run());
  EXPECT_TRUE(desk_.is_held());
  EXPECT_EQ(server_.take_json(kFirst).back()["ok"], true);
  send(kSecond, "/release_control", "{}");
  EXPECT_TRUE(desk_.is_held()) << "it is another connection's";
  send(kFirst, "/release_control", "{}");
  EXPECT_FALSE(desk_.is_held());
}

// ---- parameters

class ParametersOfClients : public ControlOfAGateway {
 protected:
  ParameterAnswer read(const BenchList& /*benches*/,
                       const std::vector<std::string>& names) override {
    ParameterAnswer answer;
    for (const std::string& name : names) answer.parameters.push_back({name, value_});
    return answer;
  }

  ParameterAnswer write(const SessionPointer& /*own*/, const BenchList& benches,
                        const std::vector<ParameterChange>& changes) override {
    value_ = changes.front().value;
    ParameterAnswer answer = read(benches, {changes.front().name});
    answer.complaints.emplace_back("out of range");
    return answer;
  }

  std::int64_t value_ = 5;
  BenchList benches_ = std::make_shared<std::vector<KnownBench>>();
  ParameterDesk parameters_{*this, server_, clients_, desk_};
};

TEST_F(ParametersOfClients, ReadsForOneConnectionAndRepeatsItsNumber) {
  parameters_.get(kFirst, {.names = {"bench1/x/0x6081"}, .id = "a"}, benches_);
  ASSERT_TRUE(server_.run());
  const auto sent = server_.take_json(kFirst);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0]["parameters"][0], Json({{"name", "bench1/x/0x6081"}, {"value", 5}}));
  EXPECT_EQ(sent[0]["id"], "a");
  EXPECT_THAT(server_.take(kSecond), IsEmpty());
}

TEST_F(ParametersOfClients, WritesOnlyWithControlAndReportsWhatWasRefused) {
  const SetParameters change{.parameters = {{.name = "p", .value = 8}}, .id = {}};
  parameters_.set(kFirst, change, benches_);
  EXPECT_THAT(std::string(server_.take_json(kFirst).at(0)["message"]),
              HasSubstr("take control first"));
  EXPECT_EQ(take(kFirst), "");
  (void)server_.take(kFirst);
  parameters_.set(kFirst, change, benches_);
  ASSERT_TRUE(server_.run());
  const auto sent = server_.take_json(kFirst);
  ASSERT_THAT(sent, SizeIs(2));
  EXPECT_EQ(sent[0]["message"], "out of range");
  EXPECT_EQ(sent[1]["parameters"][0]["value"], 8);
}

TEST_F(ParametersOfClients, SendsSubscribedParametersAtFirstAndWhenTheyChange) {
  parameters_.subscribe(kFirst, {.is_on = true, .names = {"p", "q"}});
  const auto poll = [&] {
    parameters_.poll(benches_);
    EXPECT_TRUE(server_.run());
    return server_.take_json(kFirst);
  };
  EXPECT_EQ(poll().at(0)["parameters"].size(), 2U);
  EXPECT_THAT(poll(), IsEmpty());
  value_ = 6;
  parameters_.subscribe(kFirst, {.is_on = false, .names = {"q"}});
  const auto sent = poll();
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0]["parameters"], Json::array({{{"name", "p"}, {"value", 6}}}));
}

TEST_F(ParametersOfClients, DoesNotPollAgainBeforeTheAnswer) {
  parameters_.subscribe(kFirst, {.is_on = true, .names = {"p"}});
  parameters_.poll(benches_);
  parameters_.poll(benches_);
  ASSERT_TRUE(server_.run());
  EXPECT_EQ(server_.waiting(), 0U);
  parameters_.forget(kFirst);
  parameters_.poll(benches_);
  EXPECT_EQ(server_.waiting(), 0U) << "nobody has subscribed any";
}

TEST_F(ParametersOfClients, LimitsTheSubscriptionsOfAConnection) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i <= ParameterDesk::kMost; ++i) names.push_back(std::to_string(i));
  parameters_.subscribe(kFirst, {.is_on = true, .names = names});
  EXPECT_EQ(server_.take_json(kFirst).at(0)["message"],
            "a connection can subscribe to at most 512 parameters");
}

// ---- connections

TEST(ClientTable, CountsAndNamesOpenConnections) {
  ClientTable clients;
  clients.open(7);
  EXPECT_EQ(clients.name(7), "client 7");
  clients.rename(7, "lab");
  EXPECT_EQ(clients.name(7), "lab");
  EXPECT_EQ(clients.count(), 1U);
  EXPECT_TRUE(clients.close(7));
  EXPECT_FALSE(clients.close(7));
  EXPECT_FALSE(clients.contains(7));
  EXPECT_EQ(clients.count(), 0U);
}

}  // namespace
}  // namespace vdrive::gateway

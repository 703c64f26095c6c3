// SPDX-License-Identifier: Apache-2.0
#include "channel_table.hpp"

#include "client_table.hpp"
#include "gateway/recorded_server.hpp"
#include "graph_feed.hpp"
#include "services.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::gateway {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr ConnectionId kPage = 1;
constexpr ConnectionId kTool = 2;
constexpr ChannelTable::Clock::time_point kBegin{1h};

ChannelPointer topic(std::uint32_t id, const std::string& name) {
  ChannelInfo info;
  info.id = id;
  info.topic = name;
  return std::make_shared<Channel>(std::move(info));
}

/// A table with the topics of bench 4 and two open connections, whose first messages have been
/// taken.
class Topics : public testing::Test {
 protected:
  Topics() {
    table_.open(kPage);
    table_.open(kTool);
    table_.add(4, {status_, state_});
    (void)server_.take(kPage);
    (void)server_.take(kTool);
  }

  std::string subscribe(ConnectionId id, std::uint32_t subscription, std::uint32_t channel) {
    ChannelPointer subscribed;
    return table_.subscribe(id, {.id = subscription, .channel = channel}, subscribed);
  }

  /// @return a batch of bench 4 with a status message.
  [[nodiscard]] Batch batch(std::uint64_t time) const {
    return {.bench = 4, .time = time, .messages = {{status_, share("bytes")}}};
  }

  RecordedServer server_;
  ChannelTable table_{server_};
  ChannelPointer status_ = topic(10, "/bench4/status");
  ChannelPointer state_ = topic(11, "/bench4/state");
};

TEST_F(Topics, AdvertisesTopicsToOpenConnectionsAndToThoseThatOpenLater) {
  table_.add(5, {topic(12, "/bench5/status")});
  const auto open = server_.take_json(kPage);
  ASSERT_THAT(open, SizeIs(1));
  EXPECT_EQ(open[0]["op"], "advertise");
  EXPECT_EQ(open[0]["channels"][0]["topic"], "/bench5/status");
  table_.open(3);
  EXPECT_THAT(server_.take_json(3), SizeIs(2)) << "one message for each bench";
}

TEST_F(Topics, SendsAMessageToEachSubscriptionUnderItsOwnNumber) {
  EXPECT_EQ(subscribe(kPage, 7, 10), "");
  EXPECT_EQ(subscribe(kTool, 8, 10), "");
  table_.publish(batch(0), kBegin);
  // 1 = message data, the subscription in four bytes, the time in eight bytes.
  EXPECT_THAT(server_.take(kPage), ElementsAre(std::string("\1\7\0\0\0\0\0\0\0\0\0\0\0bytes", 18)));
  EXPECT_THAT(server_.take(kTool),
              ElementsAre(std::string("\1\10\0\0\0\0\0\0\0\0\0\0\0bytes", 18)));
}

TEST_F(Topics, TellsThePublisherWhetherATopicIsWantedAndThatAReceiverIsNew) {
  EXPECT_FALSE(status_->is_wanted());
  EXPECT_EQ(subscribe(kPage, 7, 10), "");
  EXPECT_TRUE(status_->is_wanted());
  EXPECT_TRUE(status_->has_new_receiver);
  EXPECT_EQ(table_.unsubscribe(kPage, 7), "");
  EXPECT_FALSE(status_->is_wanted());
}

TEST_F(Topics, RefusesWrongSubscriptionsWithTheReason) {
  EXPECT_EQ(subscribe(kPage, 1, 99), "channel 99 does not exist");
  EXPECT_EQ(subscribe(kPage, 1, 10), "");
  EXPECT_EQ(subscribe(kPage, 1, 11), "subscription 1 exists already");
  EXPECT_EQ(table_.unsubscribe(kPage, 5), "subscription 5 does not exist");
  EXPECT_EQ(table_.subscriptions(), 1U);
}

TEST_F(Topics, LimitsTheSubscriptionsOfAConnection) {
  for (std::uint32_t id = 0; id < ChannelTable::kMostSubscriptions; ++id) {
    ASSERT_FALSE(table_.is_full(kPage));
    ASSERT_EQ(subscribe(kPage, id, 10), "");
  }
  EXPECT_TRUE(table_.is_full(kPage));
  EXPECT_THAT(subscribe(kPage, ChannelTable::kMostSubscriptions, 10), HasSubstr("16384"));
  EXPECT_EQ(subscribe(kTool, 1, 10), "") << "the limit is that of one connection";
}

TEST_F(Topics, EndsTheSubscriptionsOfAClosedConnection) {
  EXPECT_EQ(subscribe(kPage, 1, 10), "");
  EXPECT_EQ(subscribe(kTool, 1, 10), "");
  EXPECT_EQ(subscribe(kTool, 2, 11), "");
  EXPECT_EQ(table_.subscribed(), 2U);
  table_.close(kTool);
  EXPECT_EQ(table_.subscribed(), 1U);
  EXPECT_EQ(table_.subscriptions(), 1U);
  EXPECT_FALSE(state_->is_wanted());
  table_.publish(batch(0), kBegin);
  EXPECT_THAT(server_.take(kTool), IsEmpty());
}

TEST_F(Topics, RemovesTheTopicsOfABenchWithTheirSubscriptions) {
  EXPECT_EQ(subscribe(kPage, 1, 10), "");
  table_.remove(4, {status_, state_});
  const auto sent = server_.take_json(kTool);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0]["op"], "unadvertise");
  EXPECT_EQ(sent[0]["channelIds"], Json::array({10, 11}));
  EXPECT_EQ(table_.size(), 0U);
  EXPECT_FALSE(status_->is_wanted());
  EXPECT_EQ(table_.unsubscribe(kPage, 1), "subscription 1 does not exist");
  table_.open(3);
  EXPECT_THAT(server_.take(3), IsEmpty()) << "it is not advertised any more";
}

TEST_F(Topics, SendsAllTheTimeOfTheBenchWithTheLowestNumber) {
  table_.add(6, {topic(12, "/bench6/status")});
  (void)server_.take(kPage);
  (void)server_.take(kTool);
  table_.publish({.bench = 6, .time = 5}, kBegin);
  EXPECT_THAT(server_.take(kPage), IsEmpty()) << "the clock is that of bench 4";
  table_.publish({.bench = 4, .time = 5}, kBegin);
  // 2 = time, in eight bytes.
  EXPECT_THAT(server_.take(kPage), ElementsAre(std::string("\2\5\0\0\0\0\0\0\0", 9)));
  EXPECT_THAT(server_.take(kTool), SizeIs(1)) << "without a subscription too";
}

TEST_F(Topics, SendsTheTimeOnceInAPeriodAndNoneBeforeTheFirstTick) {
  table_.publish({.bench = 4, .time = 0}, kBegin);
  EXPECT_THAT(server_.take(kPage), IsEmpty());
  table_.publish({.bench = 4, .time = 1}, kBegin);
  table_.publish({.bench = 4, .time = 2}, kBegin + ChannelTable::kTimePeriod - 1ms);
  EXPECT_THAT(server_.take(kPage), SizeIs(1));
  table_.publish({.bench = 4, .time = 3}, kBegin + ChannelTable::kTimePeriod);
  EXPECT_THAT(server_.take(kPage), SizeIs(1));
}

// ---- batches

TEST_F(Topics, PublishesBatchesInTheThreadOfTheServer) {
  EXPECT_EQ(subscribe(kPage, 7, 10), "");
  table_.put(batch(0));
  table_.put(batch(0));
  EXPECT_THAT(server_.take(kPage), IsEmpty());
  ASSERT_TRUE(server_.run(2));
  EXPECT_THAT(server_.take(kPage), SizeIs(2));
}

TEST_F(Topics, LeavesNewBatchesOutAndCountsThemWhileTheServerIsLate) {
  EXPECT_EQ(subscribe(kPage, 7, 10), "");
  for (std::size_t i = 0; i < ChannelTable::kMostBatches + 2; ++i) table_.put(batch(0));
  EXPECT_EQ(table_.lost_batches(), 2U);
  ASSERT_TRUE(server_.run(ChannelTable::kMostBatches));
  EXPECT_THAT(server_.take(kPage), SizeIs(ChannelTable::kMostBatches));
  EXPECT_EQ(server_.waiting(), 0U);
  table_.put(batch(0));
  ASSERT_TRUE(server_.run());
  EXPECT_THAT(server_.take(kPage), SizeIs(1)) << "there is room again";
}

// ---- the graph of connections

class GraphOfConnections : public Topics {
 protected:
  GraphOfConnections() {
    clients_.open(kPage);
    clients_.open(kTool);
    clients_.rename(kTool, "lab");
  }

  ClientTable clients_;
  GraphFeed graph_{server_, table_, clients_};
};

TEST_F(GraphOfConnections, NamesThePublisherAndTheReceiversOfEachTopic) {
  EXPECT_EQ(subscribe(kPage, 1, 10), "");
  EXPECT_EQ(subscribe(kTool, 1, 10), "");
  graph_.subscribe(kPage, true);
  const auto sent = server_.take_json(kPage);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0]["op"], "connectionGraphUpdate");
  EXPECT_EQ(sent[0]["publishedTopics"][0],
            Json({{"name", "/bench4/status"}, {"publisherIds", Json::array({"bench4"})}}));
  EXPECT_EQ(
      sent[0]["subscribedTopics"][0],
      Json({{"name", "/bench4/status"}, {"subscriberIds", Json::array({"client 1", "lab"})}}));
  EXPECT_EQ(sent[0]["subscribedTopics"][1]["subscriberIds"], Json::array());
  EXPECT_EQ(sent[0]["advertisedServices"].size(), services().size());
}

TEST_F(GraphOfConnections, SendsAChangeOnceAndOnlyToThoseThatWantIt) {
  graph_.subscribe(kPage, true);
  graph_.send_changes();
  (void)server_.take(kPage);
  graph_.send_changes();
  EXPECT_THAT(server_.take(kPage), IsEmpty()) << "nothing has changed";
  table_.remove(4, {status_});
  (void)server_.take(kPage);
  (void)server_.take(kTool);
  graph_.send_changes();
  const auto sent = server_.take_json(kPage);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0]["removedTopics"], Json::array({"/bench4/status"}));
  EXPECT_THAT(server_.take(kTool), IsEmpty());
  graph_.subscribe(kPage, false);
  EXPECT_EQ(subscribe(kTool, 1, 11), "");
  graph_.send_changes();
  EXPECT_THAT(server_.take(kPage), IsEmpty());
}

}  // namespace
}  // namespace vdrive::gateway

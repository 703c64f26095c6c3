// SPDX-License-Identifier: Apache-2.0
// The state of services, judged by the age of their samples.
#include "presence/service_watch.hpp"

#include "bench_messages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

class ServiceWatchTest : public testing::Test {
 protected:
  void describe(std::uint64_t incarnation, msg::ClockMode clock_mode, bool alive = true) {
    auto message = description(1, incarnation);
    message.clock_mode = clock_mode;
    message.alive = alive;
    directory_.on_description(message, kSource, kStart);
  }

  /// @return the kinds of the changes at `now`.
  std::vector<ServiceNews> news(std::chrono::milliseconds now) {
    std::vector<ServiceNews> changes;
    for (const ServiceChange& change : sut_.changes(directory_, kStart + now)) {
      EXPECT_EQ(change.bench, 1U);
      EXPECT_FALSE(change.text.empty());
      changes.push_back(change.news);
    }
    return changes;
  }

  wire::PresenceByAge presence_{{}};
  Directory directory_{presence_};
  ServiceWatch sut_;
};

TEST_F(ServiceWatchTest, ReportsSilenceWithin100MillisecondsWhileTheBenchTicks) {
  describe(10, msg::ClockMode::realtime);
  directory_.on_state(state(1, 10), kStart);
  EXPECT_THAT(news(0ms), ElementsAre(ServiceNews::found));
  directory_.note_sample({1, 10}, 5, kStart + 40ms);
  EXPECT_THAT(news(110ms), IsEmpty());
  const auto changes = sut_.changes(directory_, kStart + 125ms);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].news, ServiceNews::fell_silent);
  EXPECT_EQ(changes[0].silence, 85ms);
  EXPECT_EQ(changes[0].text, "bench 1 stopped sending 85 ms ago");
  EXPECT_THAT(news(500ms), IsEmpty()) << "reported once";
}

// A sample may still arrive from the socket before the bench has discovered this program again.
TEST_F(ServiceWatchTest, AllowsABenchTheTimeToFindThisProgramAgain) {
  describe(10, msg::ClockMode::realtime);
  directory_.on_state(state(1, 10), kStart);
  EXPECT_THAT(news(0ms), ElementsAre(ServiceNews::found));
  EXPECT_EQ(presence_.running_time(kStart), kStart);
  ASSERT_EQ(presence_.running_time(kStart + 4s), kStart + 50ms) << "it did not run";
  directory_.note_sample({1, 10}, 5, kStart + 50ms);
  EXPECT_THAT(news(549ms), IsEmpty());
  EXPECT_THAT(news(550ms), ElementsAre(ServiceNews::fell_silent)) << "it has not come back";
}

TEST_F(ServiceWatchTest, AllowsTheLongerIntervalOfABenchThatStandsStill) {
  describe(10, msg::ClockMode::lockstep);
  directory_.on_state(state(1, 10), kStart);
  EXPECT_THAT(news(0ms), ElementsAre(ServiceNews::found));
  EXPECT_THAT(news(240ms), IsEmpty());
  EXPECT_THAT(news(260ms), ElementsAre(ServiceNews::fell_silent));
}

TEST_F(ServiceWatchTest, DistinguishesTheSameRunFromARestart) {
  describe(10, msg::ClockMode::realtime);
  directory_.on_state(state(1, 10), kStart);
  EXPECT_THAT(news(0ms), ElementsAre(ServiceNews::found));
  EXPECT_THAT(news(200ms), ElementsAre(ServiceNews::fell_silent));
  directory_.on_state(state(1, 10), kStart + 300ms);
  EXPECT_THAT(news(300ms), ElementsAre(ServiceNews::sends_again));
  describe(11, msg::ClockMode::realtime);
  directory_.on_state(state(1, 11), kStart + 500ms);
  EXPECT_THAT(news(500ms), ElementsAre(ServiceNews::fell_silent, ServiceNews::restarted));
}

TEST_F(ServiceWatchTest, DistinguishesAnEndFromSilence) {
  describe(10, msg::ClockMode::realtime);
  directory_.on_state(state(1, 10), kStart);
  EXPECT_THAT(news(0ms), ElementsAre(ServiceNews::found));
  describe(10, msg::ClockMode::realtime, false);
  EXPECT_THAT(news(10ms), ElementsAre(ServiceNews::went_offline));
}

TEST_F(ServiceWatchTest, KeepsTheEarlierOfTwoRuns) {
  describe(10, msg::ClockMode::realtime);
  describe(11, msg::ClockMode::realtime);
  directory_.on_state(state(1, 10), kStart);
  directory_.on_state(state(1, 11), kStart);
  EXPECT_THAT(news(0ms), ElementsAre(ServiceNews::found));
  EXPECT_THAT(news(10ms), IsEmpty());
  directory_.on_state(state(1, 11), kStart + 100ms);
  EXPECT_THAT(news(120ms), ElementsAre(ServiceNews::fell_silent, ServiceNews::restarted));
}

}  // namespace
}  // namespace vdrive::client

// SPDX-License-Identifier: Apache-2.0
// When a search for benches ends, and its message. Time is an argument.
#include "presence/search.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;

constexpr SearchClock::time_point kSearchBegin{1h};

TEST(SearchTime, EndsAfterItsTime) {
  const SearchTime sut(kSearchBegin, 2s);
  EXPECT_EQ(sut.end(false), kSearchBegin + 2s);
}

TEST(SearchTime, IsThreeTimesAsLongForAServiceThatAnnouncedItself) {
  const SearchTime sut(kSearchBegin, 2s);
  EXPECT_EQ(sut.end(true), kSearchBegin + 6s);
}

TEST(SearchTime, IsLongerByFourTimesTheDelayOfTheMachine) {
  SearchTime sut(kSearchBegin, 2s);
  sut.note_wait(kSearchBegin + 20ms, kSearchBegin + 70ms);
  sut.note_wait(kSearchBegin + 90ms, kSearchBegin + 140ms);
  EXPECT_EQ(sut.delay(), 100ms);
  EXPECT_EQ(sut.end(false), kSearchBegin + 2400ms);
}

TEST(SearchTime, CountsNoDelayWhereAMessageEndsTheWait) {
  SearchTime sut(kSearchBegin, 2s);
  sut.note_wait(kSearchBegin + 20ms, kSearchBegin + 5ms);
  EXPECT_EQ(sut.delay(), 0ms);
}

TEST(SearchTime, EndsOnAMachineThatStandsStill) {
  SearchTime sut(kSearchBegin, 2s);
  sut.note_wait(kSearchBegin, kSearchBegin + 1h);
  EXPECT_EQ(sut.end(false), kSearchBegin + 8s);
  EXPECT_EQ(sut.end(true), kSearchBegin + 12s);
}

TEST(SettlingSearch, EndsOnceNoFurtherBenchComes) {
  SearchCompletion sut(kSearchBegin);
  const SearchFindings one{.present = 1, .participants = 1, .services = 1};
  EXPECT_FALSE(sut.has_ended({}, kSearchBegin));
  EXPECT_FALSE(sut.has_ended(one, kSearchBegin + 10ms));
  EXPECT_FALSE(sut.has_ended(one, kSearchBegin + 159ms));
  EXPECT_TRUE(sut.has_ended(one, kSearchBegin + 160ms));
}

TEST(SettlingSearch, LooksAgainWhenItMayEnd) {
  SearchCompletion sut(kSearchBegin);
  const auto never = SearchClock::time_point::max();
  EXPECT_EQ(sut.next_end(kSearchBegin), never);
  const SearchFindings service{.participants = 1, .services = 1, .undescribed = 1};
  const SearchFindings bench{.present = 1, .participants = 1, .services = 1};
  EXPECT_FALSE(sut.has_ended(service, kSearchBegin + 4ms));
  EXPECT_FALSE(sut.has_ended(bench, kSearchBegin + 10ms));
  EXPECT_EQ(sut.next_end(kSearchBegin + 10ms), kSearchBegin + 154ms);   // 150 ms after the service
  EXPECT_EQ(sut.next_end(kSearchBegin + 154ms), kSearchBegin + 160ms);  // and after the bench
  EXPECT_EQ(sut.next_end(kSearchBegin + 160ms), never);
}

TEST(SettlingSearch, WaitsForAServiceThatHasNotShownItsBench) {
  SearchCompletion sut(kSearchBegin);
  const SearchFindings first{.present = 1, .participants = 2, .services = 2, .undescribed = 1};
  EXPECT_FALSE(sut.has_ended(first, kSearchBegin + 10ms));
  EXPECT_FALSE(sut.has_ended(first, kSearchBegin + 1900ms));
  const SearchFindings both{.present = 2, .participants = 2, .services = 2};
  EXPECT_TRUE(sut.has_ended(both, kSearchBegin + 1910ms));
}

TEST(SettlingSearch, DoesNotEndWithoutABench) {
  SearchCompletion sut(kSearchBegin);
  EXPECT_FALSE(sut.has_ended({.participants = 1, .services = 1}, kSearchBegin));
  EXPECT_FALSE(sut.has_ended({.participants = 1, .services = 1}, kSearchBegin + 1h));
}

TEST(TextOfASight, NamesWhatWasSeen) {
  EXPECT_EQ(text_of({}, 0ms), "seen: no other participant");
  EXPECT_EQ(text_of({.participants = 1, .services = 1, .undescribed = 1}, 9ms),
            "seen: 1 other participant, 1 service that has not described its bench");
  EXPECT_EQ(
      text_of({.participants = 4, .services = 3, .undescribed = 2, .unreachable = 1}, 340ms),
      "seen: 4 other participants, 2 services that have not described their benches, 1 service in "
      "the other security mode (open or closed), the search was delayed by 340 ms on this machine");
}

}  // namespace
}  // namespace vdrive::client

// SPDX-License-Identifier: Apache-2.0
#include "bus/bus_faults.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr auto kSent = FrameDirection::sent;
constexpr auto kReceived = FrameDirection::received;

BusFault fault_of(std::string_view text) {
  return std::get<BusFault>(parse_fault_of_node(text));
}

std::string refusal_of(std::string_view text) {
  const auto parsed = parse_fault_of_node(text);
  const auto* const refusal = std::get_if<std::string>(&parsed);
  return refusal == nullptr ? "" : *refusal;
}

BusFaults faults_of(std::string_view text) {
  BusFaults faults;
  EXPECT_TRUE(faults.add(fault_of(text), 0us));
  return faults;
}

/// @return the numbers of the frames lost among the first 10,000.
std::vector<std::uint64_t> lost_frames(BusFaults faults, std::uint8_t node,
                                       FrameDirection direction) {
  std::vector<std::uint64_t> lost;
  for (std::uint64_t number = 1; number <= 10'000; ++number) {
    if (faults.fate_of(node, direction, number, 0us).is_lost) lost.push_back(number);
  }
  return lost;
}

TEST(BusFault, IsReadInTheWordsOfAPerson) {
  EXPECT_EQ(fault_of("lost"), (BusFault{.kind = BusFaultKind::lost}));
  EXPECT_EQ(fault_of("  3   lost  5% "),
            (BusFault{.kind = BusFaultKind::lost, .node = 3, .percent = 5}));
  EXPECT_EQ(fault_of("0 doubled"), (BusFault{.kind = BusFaultKind::doubled}));
  EXPECT_EQ(fault_of("late 4ms 10% sent seed 7 from 2s for 500ms"),
            (BusFault{.kind = BusFaultKind::late,
                      .percent = 10,
                      .direction = kSent,
                      .delay = 4ms,
                      .seed = 7,
                      .from = 2s,
                      .until = 2'500ms}));
  EXPECT_EQ(fault_of("127 bus_off for 1s from 1s"),
            (BusFault{.kind = BusFaultKind::bus_off, .node = 127, .from = 1s, .until = 2s}));
  EXPECT_EQ(fault_of("2 duplicate").kind, BusFaultKind::duplicate);
}

TEST(BusFault, BeginsNowWhereItDoesNotSayWhen) {
  const auto fault = std::get<BusFault>(parse_bus_fault("lost received for 1ms", 5s));
  EXPECT_EQ(fault.from, DriveTime(5s));
  EXPECT_EQ(fault.until, DriveTime(5'001ms));
  EXPECT_EQ(fault.direction, kReceived);
}

TEST(BusFault, IsRefusedWithTheWordThatIsWrongAndWhatMayBeWritten) {
  const std::vector<std::pair<std::string, std::string>> rows{
      {"", "a word is missing at the end"},
      {"3", "missing"},
      {"gone", "'gone' is not a fault of the bus"},
      {"128 lost", "1 to 127"},
      {"lost 0%", "'0%' is not 1% to 100%"},
      {"lost 101%", "'101%'"},
      {"lost %", "'%'"},
      {"late", "missing"},
      {"late 0ms", "late needs a time above 0"},
      {"lost for 0s", "for needs a time above 0"},
      {"late soon", "'soon' is not a time"},
      {"lost from", "missing"},
      {"lost for x", "'x' is not a time"},
      {"lost seed -1", "'-1' is not a seed"},
      {"lost sideways", "'sideways' does not apply to lost"},
      {"bus_off 5%", "'5%' does not apply to bus_off"},
      {"duplicate sent", "'sent' does not apply to duplicate"},
  };
  for (const auto& [text, reason] : rows) {
    EXPECT_THAT(refusal_of(text), HasSubstr(reason)) << text;
    EXPECT_THAT(refusal_of(text), HasSubstr("such as late 4ms 10%")) << text;
  }
}

TEST(BusFaults, HitTheSameFramesInEachRun) {
  const auto lost = lost_frames(faults_of("lost 5% seed 7"), 3, kSent);
  EXPECT_EQ(lost_frames(faults_of("lost 5% seed 7"), 3, kSent), lost);
  EXPECT_NE(lost_frames(faults_of("lost 5% seed 8"), 3, kSent), lost);
  EXPECT_NE(lost_frames(faults_of("lost 5% seed 7"), 3, kReceived), lost);
}

// 5 % of 10,000 frames: 500, with a standard deviation of 22.
TEST(BusFaults, HitAsManyFramesAsTheySay) {
  EXPECT_NEAR(static_cast<double>(lost_frames(faults_of("lost 5%"), 1, kSent).size()), 500, 110);
  EXPECT_EQ(lost_frames(faults_of("lost"), 1, kSent).size(), 10'000U);
}

TEST(BusFaults, OfEveryNodeHitAFrameAtEachOfThemOrAtNone) {
  const auto lost = lost_frames(faults_of("lost 30%"), 1, kReceived);
  EXPECT_EQ(lost_frames(faults_of("lost 30%"), 127, kReceived), lost);
  EXPECT_NE(lost_frames(faults_of("1 lost 30%"), 1, kReceived), lost) << "a fault of its own";
  EXPECT_TRUE(lost_frames(faults_of("1 lost 30%"), 2, kReceived).empty());
}

TEST(BusFaults, HitOneDirectionWhereTheySayWhich) {
  BusFaults faults = faults_of("late 4ms received");
  EXPECT_EQ(faults.fate_of(1, kReceived, 1, 0us), (FrameFate{.delay = 4ms}));
  EXPECT_EQ(faults.fate_of(1, kSent, 1, 0us), FrameFate{});
  EXPECT_EQ(faults.disturbed_frames(), 1U);
}

TEST(BusFaults, LastFromTheirBeginningToTheirEnd) {
  BusFaults faults = faults_of("doubled from 2s for 1s");
  EXPECT_FALSE(faults.fate_of(1, kSent, 1, 1'999'999us).is_doubled);
  EXPECT_TRUE(faults.fate_of(1, kSent, 1, 2s).is_doubled);
  EXPECT_TRUE(faults.fate_of(1, kSent, 1, 2'999'999us).is_doubled);
  EXPECT_FALSE(faults.fate_of(1, kSent, 1, 3s).is_doubled);
}

TEST(BusFaults, HaveTheTimeOfTheNodesThatAreTheFurthest) {
  BusFaults faults;
  faults.pass_to(2s);
  faults.pass_to(1s);
  EXPECT_EQ(faults.now(), 2s);
}

TEST(BusFaults, ActTogether) {
  BusFaults faults = faults_of("late 2ms");
  EXPECT_TRUE(faults.add(fault_of("1 late 5ms"), 0us));
  EXPECT_TRUE(faults.add(fault_of("doubled"), 0us));
  EXPECT_EQ(faults.fate_of(1, kSent, 1, 0us), (FrameFate{.is_doubled = true, .delay = 5ms}));
  EXPECT_EQ(faults.fate_of(2, kSent, 1, 0us), (FrameFate{.is_doubled = true, .delay = 2ms}));
}

TEST(BusFaults, LoseEveryFrameOfANodeThatIsBusOff) {
  BusFaults faults = faults_of("2 bus_off for 1s");
  EXPECT_TRUE(faults.fate_of(2, kSent, 1, 0us).is_lost);
  EXPECT_TRUE(faults.fate_of(2, kReceived, 1, 0us).is_lost);
  EXPECT_FALSE(faults.fate_of(1, kSent, 1, 0us).is_lost);
  EXPECT_TRUE(faults.acts(BusFaultKind::bus_off, 2, 0us));
  EXPECT_FALSE(faults.acts(BusFaultKind::bus_off, 2, 1s));
  EXPECT_FALSE(faults.acts(BusFaultKind::duplicate, 2, 0us));
}

TEST(BusFaults, AreClearedByNodeOrAll) {
  BusFaults faults = faults_of("lost");
  EXPECT_TRUE(faults.add(fault_of("1 late 5ms"), 0us));
  EXPECT_TRUE(faults.add(fault_of("2 doubled"), 0us));
  faults.clear(1);
  EXPECT_EQ(faults.fate_of(1, kSent, 1, 0us), (FrameFate{.is_lost = true}));
  EXPECT_TRUE(faults.fate_of(2, kSent, 1, 0us).is_doubled);
  faults.clear(0);
  EXPECT_TRUE(faults.empty());
}

TEST(BusFaults, AreBounded) {
  BusFaults faults;
  EXPECT_TRUE(faults.add(fault_of("lost for 1s"), 0s));
  for (std::size_t i = 1; i < BusFaults::kMostFaults; ++i) EXPECT_TRUE(faults.add({}, 0s));
  EXPECT_FALSE(faults.add({}, 999ms));
  EXPECT_TRUE(faults.add({}, 1s)) << "the first one is over";
}

}  // namespace
}  // namespace vdrive::canopen

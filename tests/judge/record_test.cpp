// SPDX-License-Identifier: Apache-2.0
// Records as other drives and other masters produce them; those of a correct master have no
// finding.
#include "judge/axis_track.hpp"
#include "judge/judged_drive.hpp"
#include "judge/words.hpp"
#include "vdrive/number_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr std::uint16_t kShownEnabled = 0x0237;
constexpr std::uint16_t kShownSwitchedOn = 0x0233;
constexpr std::uint16_t kShownFault = 0x0218;
constexpr std::uint16_t kAcknowledged = 0x1000;

/// Records of one axis, written as a script.
class Script {
 public:
  Script() : judge_({.has_time = true, .shows_reads = true}) {}

  void wait(Time time) { now_ += time; }

  void put(const decltype(Record::what)& what) {
    judge_.take({.time = now_, .line = ++line_, .axis = 5, .what = what});
  }

  void write(ObjectAddress object, std::int64_t value, Channel channel = Channel::pdo) {
    put(Write{.object = object, .value = value, .channel = channel, .writer = 1});
  }

  void word(std::uint16_t word, Channel channel = Channel::pdo) {
    write(objects::kControlword, word, channel);
  }

  void status(std::uint16_t word, bool is_asked_for = false) {
    put(Shown{
        .members = ShownMember::kStatusword, .statusword = word, .is_asked_for = is_asked_for});
  }

  void mode(std::int8_t mode) { put(Shown{.members = ShownMember::kMode, .mode = mode}); }

  void position(std::int32_t at) { put(Shown{.members = ShownMember::kPosition, .position = at}); }

  /// Begins in Operation enabled, after a long time in this mode.
  void begin(std::int8_t in_mode) {
    mode(in_mode);
    status(kShownSwitchedOn);
    word(kEnabled);
    wait(10ms);
    status(kShownEnabled);
    wait(10ms);
  }

  [[nodiscard]] Verdict end() { return judge_.end(); }

  [[nodiscard]] std::vector<std::string> findings() { return broken_rules(end()); }

 private:
  Judge judge_;
  Time now_{1s};
  std::uint64_t line_ = 0;
};

/// @param latency number of cycles from 6064h to 607Ah
std::vector<std::string> mirror_after(std::uint16_t status, std::int32_t speed,
                                      std::size_t latency) {
  Script script;
  script.position(0);
  script.begin(kCyclicPosition);
  script.status(status);
  std::vector<std::int32_t> shown(latency + 1, 0);
  for (std::int32_t i = 1; i < 300; ++i) {
    const std::int32_t noise = i % 3;
    shown.push_back(i * speed + noise);
    script.position(shown.back());
    script.write(objects::kTarget, shown[shown.size() - 1 - latency]);
    script.wait(10ms);
  }
  return script.findings();
}

TEST(AMasterWithoutPower, MayLetItsTargetFollowThePosition) {
  for (const std::uint16_t status : {kShownFault, kShownSwitchedOn}) {
    EXPECT_THAT(mirror_after(status, 0, 0), IsEmpty());
    EXPECT_THAT(mirror_after(status, 500, 2), IsEmpty()) << "the axis coasts or is pushed";
    EXPECT_THAT(mirror_after(status, 500, 100), Not(IsEmpty())) << "nobody mirrors so late";
  }
}

TEST(AMasterWithoutPower, MaySetItsSpeedTo0) {
  Script script;
  script.begin(9);
  script.write(objects::kTargetVelocity, 500);
  script.status(kShownFault);
  for (int i = 0; i < 10; ++i) {
    script.wait(300ms);
    script.write(objects::kTargetVelocity, 0);
    script.write(objects::kTargetTorque, 0);
    script.put(Reading{.object = objects::kTargetVelocity, .value = 1});
  }
  EXPECT_THAT(script.findings(), IsEmpty());
}

void send_targets_from(Script& script, std::int32_t begin, std::int32_t behind) {
  for (std::int32_t i = 0; i < 30; ++i) {
    script.write(objects::kTarget, begin + 5 * i);
    script.wait(2ms);
    script.position(begin + 5 * i - behind);
  }
}

TEST(AStream, MayHaveBegunBeforeTheLog) {
  Script script;
  script.mode(kCyclicPosition);
  script.position(0);
  script.status(kShownEnabled);
  send_targets_from(script, 5'000, 5'000);
  EXPECT_THAT(script.findings(), IsEmpty());
}

TEST(AStream, MayGoOnThroughAGapOfTheLog) {
  Script script;
  script.position(0);
  script.begin(kCyclicPosition);
  send_targets_from(script, 0, 0);
  script.put(Gap{});
  script.mode(kCyclicPosition);
  script.position(0);
  script.status(kShownEnabled);
  send_targets_from(script, 5'000, 5'000);
  EXPECT_THAT(script.findings(), IsEmpty());
}

TEST(AStream, IsNotComparedWithAPositionThatIsOld) {
  for (const bool is_old : {true, false}) {
    Script script;
    script.position(0);
    script.wait(is_old ? 5s : 5ms);
    script.begin(kCyclicPosition);
    send_targets_from(script, 5'000, 0);
    const auto names = script.findings();
    if (is_old) EXPECT_THAT(names, IsEmpty());
    if (!is_old) EXPECT_THAT(names, Contains("motion-6"));
  }
}

TEST(ARestart, TakesTheLimitsAlongThatWereWrittenBefore) {
  for (const bool restarts : {true, false}) {
    Script script;
    script.write(objects::kLowerLimit, -1'000, Channel::sdo);
    script.write(objects::kUpperLimit, 1'000, Channel::sdo);
    if (restarts) script.put(Network{.state = NodeState::initialising});
    script.put(Network{.state = NodeState::operational, .is_command = true});
    script.begin(kProfilePosition);
    script.write(objects::kTarget, 5'000);
    script.word(kSetPoint);
    script.wait(10ms);
    script.status(kShownEnabled | kAcknowledged);
    const auto names = script.findings();
    if (restarts) EXPECT_THAT(names, IsEmpty());
    if (!restarts) EXPECT_THAT(names, Contains("motion-1"));
  }
}

TEST(ARestart, MakesAnErrorCodeUnknown) {
  Script script;
  script.put(Shown{.members = ShownMember::kErrorCode, .error_code = 0x8611});
  script.put(Network{.state = NodeState::initialising});
  script.put(Network{.state = NodeState::operational, .is_command = true});
  script.status(kShownFault);
  script.word(0);
  script.wait(10ms);
  script.word(0x0080);
  EXPECT_THAT(script.findings(), Contains("state-6"));
}

TEST(APdo, MayBeUnderWayWhenTheNodeRestarts) {
  for (const Time late : {2ms, 500ms}) {
    Script script;
    script.put(Network{.state = NodeState::operational});
    script.put(ReceivePdo{});
    script.put(Network{.state = NodeState::initialising});
    script.put(Network{.state = NodeState::pre_operational});
    script.wait(late);
    script.put(ReceivePdo{});
    const auto names = script.findings();
    if (late < 200ms) EXPECT_THAT(names, IsEmpty());
    if (late > 200ms) EXPECT_THAT(names, Contains("pdo-1"));
  }
}

TEST(APdo, MayFollowAStartThatTheHeartbeatDoesNotShowYet) {
  Script script;
  script.put(Network{.state = NodeState::pre_operational});
  script.put(Network{.state = NodeState::operational, .is_command = true});
  script.wait(1ms);
  script.put(Network{.state = NodeState::pre_operational});
  script.wait(300ms);
  script.put(ReceivePdo{});
  EXPECT_THAT(script.findings(), IsEmpty());
}

TEST(APdo, ToANodeThatDidNotTakeItsStartIsFound) {
  Script script;
  script.put(Network{.state = NodeState::pre_operational});
  script.put(Network{.state = NodeState::operational, .is_command = true});
  script.wait(1500ms);
  script.put(Network{.state = NodeState::pre_operational});
  script.wait(300ms);
  script.put(ReceivePdo{});
  EXPECT_THAT(script.findings(), Contains("pdo-1"));
}

TEST(TwoSessions, AreNamedAsEventsAndLogsNameThem) {
  constexpr std::uint64_t kFirst = 0x0123456789ABCDEF;
  constexpr std::uint64_t kSecond = 42;
  Script script;
  for (const std::uint64_t writer : {kFirst, kSecond, kFirst}) {
    script.put(Write{.object = objects::kControlword, .value = 6, .writer = writer});
    script.wait(10ms);
  }
  const Verdict verdict = script.end();
  ASSERT_THAT(broken_rules(verdict), ElementsAre("writers-2"));
  const Finding& finding = verdict.findings.front();
  EXPECT_THAT(finding.happened,
              AllOf(HasSubstr(session_text(kFirst)), HasSubstr(session_text(kSecond))));
  EXPECT_EQ(writer_text(finding.lines.front()), "request " + session_text(kFirst));
}

/// @param cycles of SYNC per target
void run_sync(Script& script, Time period, int times, int cycles) {
  for (int i = 0; i < times; ++i) {
    script.put(Sync{});
    if (i % cycles == 0) {
      script.put(ReceivePdo{.number = 1, .type = 1});
      script.write(objects::kTarget, 0);
      script.position(0);
    }
    script.wait(period);
  }
}

TEST(ThePeriodOfSync, MayBeAnotherOneBeforeTheStream) {
  Script script;
  script.write(objects::kCyclePeriod, 4, Channel::sdo);
  run_sync(script, 100ms, 50, 1);
  script.begin(kCyclicPosition);
  run_sync(script, 4ms, 300, 1);
  EXPECT_THAT(script.findings(), IsEmpty());
}

TEST(ThePeriodOfSync, MayBeAFractionOfThatOfTheTargets) {
  Script script;
  script.write(objects::kCyclePeriod, 4, Channel::sdo);
  script.begin(kCyclicPosition);
  run_sync(script, 2ms, 300, 2);
  EXPECT_THAT(script.findings(), IsEmpty());
}

TEST(NumbersBeyondTheirObjects, DoNoHarm) {
  constexpr std::int64_t kLowest = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kHighest = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t index : {std::int64_t{127}, kLowest, kHighest}) {
    Script script;
    script.write(objects::kCyclePeriod, 255, Channel::sdo);
    script.write(objects::kCycleIndex, index, Channel::sdo);
    script.position(0);
    script.begin(kCyclicPosition);
    script.write(objects::kSpeedLimit, kLowest, Channel::sdo);
    for (int i = 0; i < 60; ++i) {
      script.put(Sync{});
      script.write(objects::kTarget, i % 2 == 0 ? kLowest : kHighest);
      script.write(objects::kInterpolationRecord, i % 2 == 0 ? kLowest : kHighest);
      script.wait(10ms);
    }
    script.put(KeepAlive{.limit = 1ms});
    script.wait(std::chrono::years(60));
    script.put(KeepAlive{.limit = 1ms});
    EXPECT_THAT(script.findings(), testing::AllOf(Contains("supervision-4"), Contains("sync-1")));
  }
}

TEST(AJudgeThatHasEnded, MayGoOn) {
  Script script;
  script.begin(kProfilePosition);
  script.word(0x0080 | kEnabled);
  script.put(KeepAlive{.limit = 1ms});
  script.wait(1s);
  script.put(KeepAlive{.limit = 1ms});
  EXPECT_THAT(script.findings(), Contains("supervision-4"));
  for (int i = 0; i < 20; ++i) {
    script.word(static_cast<std::uint16_t>(0x000F | (i % 2) << 8));
    script.position(i);
  }
  EXPECT_THAT(script.findings(), IsEmpty());
}

TEST(ADriveThatSendsOnlyChanges, HasAnsweredAResetByItsSilence) {
  for (const Time pause : {5'000ms, 20ms}) {
    Script script;
    script.status(kShownFault);
    script.put(Emergency{.code = 0x8611});
    script.wait(1s);
    script.word(0x0080);
    script.wait(pause / 2);
    script.word(0);
    script.wait(pause / 2);
    script.word(0x0080);
    const auto names = script.findings();
    if (pause > 1s) EXPECT_THAT(names, IsEmpty());
    if (pause < 1s) EXPECT_THAT(names, Contains("state-11"));
  }
}

TEST(ADriveThatSendsOnlyChanges, HasHomedAgainByItsSilence) {
  for (const Time pause : {1'000ms, 1ms}) {
    Script script;
    script.begin(kHoming);
    script.status(kShownEnabled | kReached | kAttained);
    script.wait(1s);
    script.word(kSetPoint);
    script.wait(pause);
    script.word(kEnabled);
    const auto names = script.findings();
    if (pause == 1s) EXPECT_THAT(names, IsEmpty());
    if (pause < 1s) EXPECT_THAT(names, Contains("homing-4"));
  }
}

TEST(AHomingThatHasItsOriginAndStillMoves, MayHaveItsWordAgain) {
  constexpr std::uint16_t kMoves = 0x0237;
  for (const bool moves : {true, false}) {
    Script script;
    script.begin(kHoming);
    script.word(kSetPoint, Channel::sdo);
    script.wait(10ms);
    script.status(kMoves);
    script.wait(100ms);
    script.status(kMoves | kAttained | (moves ? 0U : kReached));
    script.wait(10ms);
    script.word(kSetPoint, Channel::sdo);
    const auto names = script.findings();
    if (moves) EXPECT_THAT(names, IsEmpty());
    if (!moves) EXPECT_THAT(names, Contains("homing-3"));
  }
}

/// A master by PDOs, then one by SDO, then one by PDOs again.
std::vector<std::string> hand_over(Time pause, bool restarts) {
  Script script;
  script.status(0x0231);
  script.word(0x0006);
  script.wait(pause);
  script.word(0x0007, Channel::sdo);
  script.wait(10ms);
  script.status(kShownSwitchedOn);
  script.word(0x0000, Channel::sdo);
  script.wait(10ms);
  if (restarts) {
    script.put(Network{.state = NodeState::pre_operational, .is_command = true});
    script.wait(1s);
    script.put(Network{.state = NodeState::operational, .is_command = true});
  }
  script.status(0x0250);
  script.word(0x0006);
  return script.findings();
}

TEST(TwoMastersOneAfterTheOther, WriteOneObjectEachByItsOwnWay) {
  EXPECT_THAT(hand_over(5s, false), IsEmpty());
  EXPECT_THAT(hand_over(10ms, true), IsEmpty());
  EXPECT_THAT(hand_over(10ms, false), Contains("writers-1"));
}

TEST(ATargetInProfilePosition, IsNoSetPointWhereBit4DoesNotRise) {
  Script script;
  script.begin(kProfilePosition);
  for (int i = 0; i < 60; ++i) {
    script.write(objects::kTarget, i);
    script.wait(10ms);
  }
  EXPECT_THAT(script.findings(), IsEmpty());
}

// The master sets 607Ah for its stream while bit 4 of the last set-point is still set.
TEST(ATargetInProfilePosition, MayBeThatOfTheCyclicModeThatFollows) {
  Script script;
  script.position(100);
  script.begin(kProfilePosition);
  script.write(objects::kTarget, 100);
  script.word(kSetPoint);
  script.wait(10ms);
  script.status(kShownEnabled | kAcknowledged);
  script.wait(1s);
  script.position(101);
  script.write(objects::kTarget, 101);
  script.write(objects::kMode, kCyclicPosition, Channel::sdo);
  script.wait(10ms);
  script.mode(kCyclicPosition);
  script.word(kSetPoint, Channel::pdo);
  script.wait(1s);
  script.word(kSetPoint, Channel::pdo);
  EXPECT_THAT(script.findings(), IsEmpty());
}

TEST(AStatusThatTheMasterAskedFor, HasBit12OfTheModeOfItsTime) {
  Script script;
  const auto ask = [&script](std::uint16_t word, std::int8_t mode) {
    script.put(Shown{.members = ShownMember::kMode, .mode = mode, .is_asked_for = true});
    if (word != 0) script.status(word, true);
    script.wait(10ms);
  };
  ask(kShownSwitchedOn, kProfilePosition);
  script.word(kEnabled, Channel::sdo);
  script.wait(10ms);
  ask(kShownEnabled, kProfilePosition);
  script.write(objects::kTarget, 100, Channel::sdo);
  script.word(kSetPoint, Channel::sdo);
  script.wait(10ms);
  ask(kShownEnabled | kAcknowledged, kProfilePosition);
  script.word(kEnabled, Channel::sdo);
  script.wait(10ms);
  ask(kShownEnabled, kProfilePosition);
  script.write(objects::kMode, kHoming, Channel::sdo);
  ask(kShownEnabled | kReached | kAttained, kHoming);
  script.write(objects::kMode, kProfilePosition, Channel::sdo);
  ask(0, kProfilePosition);  // 6061h alone
  script.write(objects::kTarget, 200, Channel::sdo);
  script.word(kSetPoint, Channel::sdo);
  EXPECT_THAT(script.findings(), IsEmpty());
}

TEST(AModeOfTheMaker, HasTargetsThatNobodyKnows) {
  for (const std::int8_t mode : {std::int8_t{-1}, std::int8_t{11}}) {
    Script script;
    script.begin(mode);
    for (int i = 0; i < 10; ++i) {
      script.write(objects::kTarget, 100 * i);
      script.wait(10ms);
    }
    EXPECT_THAT(script.findings(), IsEmpty());
  }
}

}  // namespace
}  // namespace vdrive::judge

// SPDX-License-Identifier: Apache-2.0
// Masters judged by the journal of their bench, which an engine without network and clock writes.
#include "replayed/bench_journal.hpp"

#include "base/content_check.hpp"
#include "journal/journal.hpp"
#include "judge/judged_drive.hpp"
#include "service/engine_under_test.hpp"
#include "vdrive/cia402/controlword.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

namespace vdrive::judge {
namespace {

using test::EngineUnderTest;
using test::kAlice;
using test::kBob;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr std::uint16_t kControlword = 0x6040;
constexpr std::uint16_t kMode = 0x6060;
constexpr std::uint16_t kTarget = 0x607A;

/// Runs a master on a bench without a watchdog. @return the journal of that bench.
std::string journal_of(const std::function<void(EngineUnderTest&)>& master, std::size_t axes = 1) {
  std::string bytes;
  service::Configuration configuration = test::bench_configuration(axes);
  configuration.watchdog.reset();
  EngineUnderTest bench(configuration);
  service::Journal journal(
      configuration,
      [&bytes](std::span<const std::byte> part) {
        const auto* const text = reinterpret_cast<const char*>(part.data());  // NOLINT: raw bytes
        bytes.append(text, part.size());
      },
      bench.counters);
  bench.engine.record_to(journal);
  master(bench);
  journal.close();
  return bytes;
}

JournalVerdict verdict_on(const std::string& journal) {
  std::istringstream stream(journal);
  EXPECT_TRUE(is_journal(stream));
  return judge_journal(stream);
}

std::vector<std::string> findings(const std::function<void(EngineUnderTest&)>& master) {
  return broken_rules(verdict_on(journal_of(master)).verdict);
}

void step_until(EngineUnderTest& bench, std::uint16_t mask, std::uint16_t value) {
  for (int tick = 0; tick < 5'000 && (bench.value(1, 0x6041) & mask) != value; ++tick) {
    bench.steps(1);
  }
  ASSERT_EQ(bench.value(1, 0x6041) & mask, value);
}

/// Goes through the state machine to Operation enabled, reading 6041h after each word.
void enable(EngineUnderTest& bench, std::uint64_t session = kAlice) {
  bench.write(session, 1, kMode, 1);
  bench.steps(1);
  bench.write(session, 1, kControlword, controlwords::kShutdown);
  step_until(bench, 0x6F, 0x21);
  bench.write(session, 1, kControlword, controlwords::kSwitchOn);
  step_until(bench, 0x6F, 0x23);
  bench.write(session, 1, kControlword, controlwords::kEnableOperation);
  step_until(bench, 0x6F, 0x27);
}

void move(EngineUnderTest& bench, std::int32_t target, std::uint64_t session = kAlice) {
  bench.write(session, 1, kTarget, target);
  bench.write(session, 1, kControlword, 0x1F);
  step_until(bench, Statusword::kSetPointAcknowledge, Statusword::kSetPointAcknowledge);
  bench.write(session, 1, kControlword, 0x0F);
  step_until(bench, Statusword::kSetPointAcknowledge, 0);
  step_until(bench, Statusword::kTargetReached, Statusword::kTargetReached);
}

void disable(EngineUnderTest& bench) {
  bench.write(kAlice, 1, kControlword, controlwords::kShutdown);
  step_until(bench, 0x6F, 0x21);
}

TEST(TheJournalOfABench, GivesNoFindingOfAMasterThatDoesEverythingRight) {
  EXPECT_THAT(findings([](EngineUnderTest& bench) {
                enable(bench);
                move(bench, 2'000);
                move(bench, -300);
                disable(bench);
              }),
              IsEmpty());
}

TEST(TheJournalOfABench, NamesTheTickInWhichBit4StayedUp) {
  std::uint64_t tick = 0;
  const JournalVerdict judged = verdict_on(journal_of([&tick](EngineUnderTest& bench) {
    enable(bench);
    bench.write(kAlice, 1, kTarget, 1'000);
    bench.write(kAlice, 1, kControlword, 0x1F);
    bench.steps(10);
    bench.write(kAlice, 1, kTarget, 2'000);
    tick = bench.engine.tick();
    bench.write(kAlice, 1, kControlword, 0x1F);
    bench.steps(10);
    bench.write(kAlice, 1, kControlword, 0x0F);
    bench.steps(2'000);
    disable(bench);
  }));
  const auto& all = judged.verdict.findings;
  const auto finding = std::ranges::find(all, Rule::handshake_no_edge, &Finding::rule);
  ASSERT_NE(finding, all.end());
  EXPECT_EQ(finding->first.tick, tick);
  EXPECT_EQ(finding->axis, 1U);
  EXPECT_EQ(judged.bench, test::kBench);
}

TEST(TheJournalOfABench, TellsASetPointThatTheDriveIgnored) {
  const auto master = [](bool waits) {
    return [waits](EngineUnderTest& bench) {
      enable(bench);
      for (int set_point = 1; set_point <= 4; ++set_point) {
        bench.write(kAlice, 1, kTarget, 100'000 * set_point);
        bench.write(kAlice, 1, kControlword, 0x1F);
        bench.steps(3);
        bench.write(kAlice, 1, kControlword, 0x0F);
        if (waits) step_until(bench, Statusword::kSetPointAcknowledge, 0);
        if (waits) step_until(bench, Statusword::kTargetReached, Statusword::kTargetReached);
        bench.steps(3);
      }
    };
  };
  EXPECT_THAT(findings(master(false)), Contains("handshake-4")) << "the buffer holds one";
  EXPECT_THAT(findings(master(true)), Not(Contains("handshake-4")));
}

TEST(TheJournalOfABench, TellsFramesThatCameTooLate) {
  const auto master = [](std::int64_t lead) {
    return [lead](EngineUnderTest& bench) {
      enable(bench);
      bench.acquire(kAlice, {1});
      bench.steps(20);
      auto frame = bench.make_frame(kAlice);
      auto& command = test::add_command(frame, 1);
      command.members = msg::HAS_POSITION_USER_TARGET_VALUE;
      command.position_user_target_value = 5;
      frame.apply_at_tick = bench.engine.tick() + static_cast<std::uint64_t>(lead);
      bench.receive(frame);
      bench.steps(20);
      disable(bench);
    };
  };
  EXPECT_THAT(findings(master(-3)), ElementsAre("motion-10"));
  EXPECT_THAT(findings(master(3)), IsEmpty());
}

TEST(TheJournalOfABench, KnowsTwoSessionsThatCommandOneAxisByTurns) {
  const auto master = [](std::uint64_t other) {
    return [other](EngineUnderTest& bench) {
      enable(bench);
      for (const std::uint64_t session : {kAlice, other, kAlice, other}) {
        bench.reply_to(
            bench.make_request(msg::RequestKind::release, session == kAlice ? other : kAlice));
        bench.acquire(session, {1});
        bench.write(session, 1, kTarget, static_cast<std::int64_t>(session % 100));
        bench.steps(5);
      }
    };
  };
  EXPECT_THAT(findings(master(kBob)), Contains("writers-2"));
  EXPECT_THAT(findings(master(kAlice)), Not(Contains("writers-2")));
}

TEST(TheJournalOfABench, DoesNotTakeWhatTheBenchDoesAtItsEndForTheMaster) {
  EXPECT_THAT(findings([](EngineUnderTest& bench) {
                enable(bench);
                bench.write(kAlice, 1, kTarget, 1'000'000);
                bench.write(kAlice, 1, kControlword, 0x1F);
                step_until(bench, Statusword::kSetPointAcknowledge,
                           Statusword::kSetPointAcknowledge);
                bench.write(kAlice, 1, kControlword, 0x0F);
                bench.steps(100);
                bench.engine.shut_down(service::Braking::ramp);
                bench.steps(500);
              }),
              ElementsAre("supervision-7"))
      << "the master left the axis enabled; it was the bench that stopped it";
}

TEST(TheJournalOfABench, DoesNotTakeADisturbanceForTheMaster) {
  const JournalVerdict judged = verdict_on(journal_of([](EngineUnderTest& bench) {
    enable(bench);
    bench.write(kBob, 1, 0x5E00, 10);  // a load torque
    bench.write(kAlice, 1, kTarget, 100);
    bench.write(kBob, 1, 0x5E00, 0);
    bench.steps(3);
  }));
  EXPECT_THAT(broken_rules(judged.verdict), Not(Contains("writers-2")));
}

TEST(TheJournalOfABench, KnowsTheLimitsThatTheDriveHasFromItsStart) {
  EXPECT_THAT(findings([](EngineUnderTest& bench) {
                bench.write(kAlice, 1, 0x607D, -500, 1);
                bench.write(kAlice, 1, 0x607D, 500, 2);
                enable(bench);
                bench.write(kAlice, 1, kTarget, 2'000);
                bench.write(kAlice, 1, kControlword, 0x1F);
                bench.steps(3);
                bench.write(kAlice, 1, kControlword, 0x0F);
                bench.steps(1'000);
                disable(bench);
              }),
              Contains("motion-1"));
}

TEST(TheJournalOfABench, ForgetsWhatAPowerCycleEnds) {
  EXPECT_THAT(findings([](EngineUnderTest& bench) {
                enable(bench);
                bench.reply_to(bench.make_request(msg::RequestKind::power_cycle, kAlice, {1}));
                bench.steps(5);
                enable(bench);
                move(bench, 500);
                disable(bench);
              }),
              IsEmpty());
}

/// @return `journal` with another format version in its header.
std::string with_format(std::string journal, std::uint32_t version) {
  constexpr std::size_t kHead = 24;
  std::uint32_t length = 0;
  std::memcpy(&length, &journal[4], sizeof length);
  std::memcpy(&journal[kHead + 8], &version, sizeof version);  // after the magic
  const std::uint64_t check =
      service::check_of(std::as_bytes(std::span(journal).subspan(kHead, length)));
  std::memcpy(&journal[16], &check, sizeof check);
  return journal;
}

TEST(TheJournalOfABench, OfAnOlderVersionSaysOnceThatItNamesNobody) {
  const std::string journal = journal_of([](EngineUnderTest& bench) {
    enable(bench);
    move(bench, 2'000);
    disable(bench);
  });
  const JournalVerdict judged = verdict_on(with_format(journal, 1));
  EXPECT_THAT(broken_rules(judged.verdict), IsEmpty());
  EXPECT_THAT(judged.notes, ElementsAre(HasSubstr("does not record who wrote")));
  EXPECT_THAT(verdict_on(journal).notes, IsEmpty());
  std::istringstream later(with_format(journal, 3));
  EXPECT_THROW(static_cast<void>(judge_journal(later)), std::runtime_error);
}

TEST(TheJournalOfABench, IsJudgedAsFarAsItGoesOrRefusedWhereverItIsCut) {
  const std::string journal = journal_of([](EngineUnderTest& bench) {
    enable(bench);
    move(bench, 2'000);
  });
  std::size_t judged = 0;
  for (std::size_t length = 0; length < journal.size(); length += 1 + length / 50) {
    std::istringstream stream(journal.substr(0, length));
    try {
      const JournalVerdict verdict = judge_journal(stream);
      EXPECT_THAT(verdict.notes, ElementsAre(HasSubstr("ends early")));
      ++judged;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("byte")) << length;
    }
  }
  EXPECT_GT(judged, 3U);
}

}  // namespace
}  // namespace vdrive::judge

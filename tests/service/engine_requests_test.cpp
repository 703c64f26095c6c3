// SPDX-License-Identifier: Apache-2.0
#include "service/engine_under_test.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/wire/request_kinds.hpp"

#include <gtest/gtest.h>

namespace vdrive::test {
namespace {

constexpr std::uint16_t kEnabling[] = {0x06, 0x07, 0x0F};

TEST(ReadRequest, AnswersEachObjectWithItsOwnCode) {
  EngineUnderTest bench;
  bench.steps(5);
  auto request = bench.make_request(msg::RequestKind::read, 0);
  request.objects.resize(3);
  request.objects[0].axis = 1;
  request.objects[0].index = 0x6041;
  request.objects[1].axis = 2;
  request.objects[1].index = 0x6FFF;
  request.objects[2].axis = 3;
  request.objects[2].index = 0x607D;
  request.objects[2].subindex = 7;
  const auto reply = bench.reply_to(request);
  EXPECT_EQ(reply.reason, msg::Reason::none);
  EXPECT_EQ(reply.tick, 5U) << "of the last completed tick";
  ASSERT_EQ(reply.objects.size(), 3U);
  EXPECT_EQ(reply.objects[0].abort_code, msg::Reason::none);
  EXPECT_EQ(reply.objects[0].value, 0x250);
  EXPECT_EQ(reply.objects[1].abort_code, msg::Reason{0x06020000});
  EXPECT_EQ(reply.objects[1].axis, 2U);
  EXPECT_EQ(reply.objects[2].abort_code, msg::Reason{0x06090011});
}

// Recordings, the web page and descriptions read every object. On an axis without a fault 1003h has
// no entry; the reader gets 08000024h, and that is no refusal.
TEST(ReadRequest, OfEveryObjectOfAHealthyAxisIsNoRefusal) {
  EngineUnderTest bench;
  auto request = bench.make_request(msg::RequestKind::read, 0);
  for (const ObjectDescription& object : kObjectTable) {
    auto& access = request.objects.emplace_back();
    access.axis = 1;
    access.index = object.address.index;
    access.subindex = object.address.subindex;
    if (request.objects.size() < msg::MAX_OBJECTS_PER_REQUEST && &object != &kObjectTable.back()) {
      continue;
    }
    EXPECT_EQ(bench.reply_to(request).reason, msg::Reason::none);
    request = bench.make_request(msg::RequestKind::read, 0);
  }
  EXPECT_TRUE(bench.events(msg::EventKind::refused).empty());
  EXPECT_EQ(bench.read(1, 0x1003, 1).objects[0].abort_code, msg::Reason{0x08000024});
}

TEST(ReadRequest, NamesTheAxisThatDoesNotExist) {
  EngineUnderTest bench;
  const auto reply = bench.read(9, 0x6041);
  EXPECT_EQ(reply.reason, msg::Reason::unknown_axis);
  EXPECT_EQ(reply.refused_axis, 9U);
  EXPECT_EQ(bench.read(0, 0x6041).reason, msg::Reason::unknown_axis);
}

TEST(WriteRequest, IsInForceInTheNextTickAndReadBackAtOnce) {
  EngineUnderTest bench;
  bench.steps(7);
  const auto reply = bench.write(kAlice, 1, 0x6081, 12'345);
  EXPECT_EQ(reply.tick, 8U);
  EXPECT_EQ(reply.objects[0].abort_code, msg::Reason::none);
  EXPECT_EQ(bench.value(1, 0x6081), 12'345);
}

TEST(WriteRequest, IsRefusedWithTheAbortCodeOfTheDictionary) {
  EngineUnderTest bench;
  EXPECT_EQ(bench.write(kAlice, 1, 0x6041, 1).objects[0].abort_code, msg::Reason{0x06010002});
  EXPECT_EQ(bench.write(kAlice, 1, 0x6080, 0).objects[0].abort_code, msg::Reason{0x06090032});
  EXPECT_EQ(bench.write(kAlice, 1, 0x6081, -1).objects[0].abort_code, msg::Reason{0x06090032});
  EXPECT_EQ(bench.events(msg::EventKind::refused).size(), 3U);
}

TEST(WriteRequest, OfACommandObjectAcquiresAFreeAxis) {
  EngineUnderTest bench;
  const auto reply = bench.write(kAlice, 2, 0x6040, 0x06);
  EXPECT_EQ(reply.objects[0].abort_code, msg::Reason::none);
  EXPECT_NE(reply.epoch, 0U);
  EXPECT_EQ(bench.events(msg::EventKind::control_changed).size(), 1U);
  EXPECT_EQ(bench.write(kBob, 2, 0x6081, 5).objects[0].abort_code, kLocalControl);
}

TEST(WriteRequest, OfARefusedCommandObjectAcquiresNothing) {
  EngineUnderTest bench;
  EXPECT_EQ(bench.write(kAlice, 2, 0x6040, 0x1'0000).objects[0].abort_code,
            msg::Reason{0x06090031});
  EXPECT_EQ(bench.write(kBob, 2, 0x6040, 0x06).objects[0].abort_code, msg::Reason::none);
}

TEST(WriteRequest, OfACommandObjectNeedsASession) {
  EngineUnderTest bench;
  EXPECT_EQ(bench.write(0, 1, 0x6040, 0x06).objects[0].abort_code, kLocalControl);
  EXPECT_EQ(bench.write(0, 1, 0x6081, 500).objects[0].abort_code, msg::Reason::none);
}

TEST(WriteRequest, OfAnotherSessionIsRefusedWithTheOwner) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  const auto reply = bench.write(kBob, 1, 0x6081, 500);
  EXPECT_EQ(reply.objects[0].abort_code, kLocalControl);
  EXPECT_EQ(reply.refused_axis, 1U);
  EXPECT_EQ(reply.owner_session, kAlice);
  EXPECT_EQ(bench.write(kAlice, 1, 0x6081, 500).objects[0].abort_code, msg::Reason::none);
}

TEST(WriteRequest, ReachesTestBenchInputsOfAnOwnedAxis) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  EXPECT_EQ(bench.write(kBob, 1, 0x5E00, 100).objects[0].abort_code, msg::Reason::none);
  EXPECT_EQ(bench.write(kBob, 1, 0x5E09, 1).objects[0].abort_code, msg::Reason::none);
  EXPECT_EQ(bench.write(kBob, 1, 0x5E0A, 1).objects[0].abort_code, msg::Reason::none);
  EXPECT_EQ(bench.write(kBob, 1, 0x5E0C, 1).objects[0].abort_code, msg::Reason::none);
  EXPECT_EQ(bench.write(kBob, 1, 0x5E20, 4, 6).objects[0].abort_code, msg::Reason::none)
      << "a habit";
  EXPECT_EQ(bench.write(kBob, 1, 0x5E10, 1, 1).objects[0].abort_code, kLocalControl);
}

TEST(WriteRequest, ReachesSeveralAxesAndExecutesEveryControlword) {
  EngineUnderTest bench;
  auto request = bench.make_request(msg::RequestKind::write, kAlice);
  for (const std::uint16_t word : kEnabling) {  // three controlwords before one tick
    for (const std::uint16_t axis : kFirstTwo) {
      auto& object = request.objects.emplace_back();
      object.axis = axis;
      object.index = 0x6040;
      object.value = word;
    }
  }
  bench.reply_to(request);
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x27);
  EXPECT_EQ(bench.value(2, 0x6041) & 0x6F, 0x27);
  EXPECT_EQ(bench.value(3, 0x6041) & 0x4F, 0x40);
}

service::Configuration without_watchdog() {
  service::Configuration configuration = bench_configuration(3);
  configuration.watchdog.reset();
  return configuration;
}

/// Alice owns axis 1 and has started its move to set-point 1,000,000 with controlword 003Fh.
struct MovingAxis : EngineUnderTest {
  MovingAxis() : EngineUnderTest(without_watchdog()) {
    acquire(kAlice, {1});
    write(kAlice, 1, 0x6060, 1);
    write(kAlice, 1, 0x607A, 1'000'000);
    for (const std::uint16_t word : kEnabling) write(kAlice, 1, 0x6040, word);
    steps(1);
    write(kAlice, 1, 0x6040, kNewSetPoint);
    steps(200);
  }

  static constexpr std::uint16_t kNewSetPoint = 0x3F;
  static constexpr std::uint16_t kStateBits = 0x6F;
  static constexpr std::uint16_t kQuickStopActive = 0x07;
  static constexpr std::uint16_t kOperationEnabled = 0x27;

  msg::Reason write_word(std::uint64_t session, std::int64_t word) {
    return write(session, 1, 0x6040, word).objects[0].abort_code;
  }

  [[nodiscard]] std::int64_t state() { return value(1, 0x6041) & kStateBits; }

  /// Lets Bob write, which is refused. @return the owner that the refusal names.
  [[nodiscard]] std::uint64_t owner() { return write(kBob, 1, 0x6081, 5).owner_session; }
};

TEST(StopOfAnotherSession, QuickStopsTheAxisWithAnEventForItsOwner) {
  MovingAxis bench;
  bench.events(msg::EventKind::stopped);
  EXPECT_EQ(bench.write_word(kBob, 0x02), msg::Reason::none);
  bench.steps(1);
  EXPECT_EQ(bench.state(), MovingAxis::kQuickStopActive);
  const auto events = bench.events(msg::EventKind::stopped);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].axis, 1U);
  EXPECT_EQ(events[0].session, kBob);
  EXPECT_EQ(events[0].code, 0x02U);
  EXPECT_EQ(events[0].detail, service::EventDetail(service::Label{kAlice}));
}

TEST(StopOfAnotherSession, KeepsOwnerAndEpoch) {
  MovingAxis bench;
  auto frame = bench.make_frame(kAlice);
  bench.write_word(kBob, 0x02);
  EXPECT_EQ(bench.owner(), kAlice);
  set_controlword(add_command(frame, 1), 0x00);  // quick stop active to switch on disabled
  bench.receive(frame);
  bench.steps(1);
  EXPECT_EQ(bench.state() & 0x4F, 0x40);
  EXPECT_EQ(bench.frame_refusal(), std::nullopt);
}

// Set-point and handshake remain the owner's: 003Fh with bit 8 is 013Fh.
TEST(StopOfAnotherSession, HaltsAndKeepsTheSetPoint) {
  MovingAxis bench;
  EXPECT_EQ(bench.write_word(kBob, 0x010F), msg::Reason::none);
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6040), 0x013F);
  EXPECT_EQ(bench.state(), MovingAxis::kOperationEnabled);
  bench.steps(2'000);
  EXPECT_EQ(bench.value(1, 0x606B), 0) << "at rest";
  const auto position = bench.value(1, 0x6062);
  EXPECT_LT(position, 1'000'000);
  bench.write_word(kAlice, MovingAxis::kNewSetPoint);
  bench.steps(100);
  EXPECT_GT(bench.value(1, 0x6062), position) << "the owner continues it";
}

TEST(StopOfAnotherSession, IsReportedOnce) {
  MovingAxis bench;
  bench.write_word(kBob, 0x010F);
  bench.write_word(kBob, 0x010F);
  EXPECT_EQ(bench.events(msg::EventKind::stopped).size(), 1U);
}

TEST(StopOfAnotherSession, NeedsNoSession) {
  MovingAxis bench;
  EXPECT_EQ(bench.write_word(0, 0x02), msg::Reason::none);
  bench.steps(1);
  EXPECT_EQ(bench.state(), MovingAxis::kQuickStopActive);
}

TEST(StopOfAnotherSession, CancelsPendingFramesOfTheAxis) {
  for (const std::int64_t stop : {0x0002, 0x010F}) {
    MovingAxis bench;
    auto frame = bench.make_frame(kAlice);
    set_controlword(add_command(frame, 1), 0x0F);
    frame.apply_at_tick = bench.engine.tick() + 50;
    bench.receive(frame);
    bench.write_word(kBob, stop);
    EXPECT_EQ(bench.frame_refusal(), msg::Reason::cancelled) << stop;
  }
}

// Each word of this test asks for more than a stop, or for something else.
TEST(StopOfAnotherSession, IsTheOnlyCommandThatIsAccepted) {
  MovingAxis bench;
  for (const std::int64_t word : {0x00, 0x06, 0x07, 0x0F, 0x3F,  // no stop
                                  0x80, 0x82,                    // fault reset
                                  0x0100,                        // Disable voltage
                                  0x0107,                        // Disable operation
                                  0x011F, 0x12,                  // a set-point
                                  0x1'0002, -0xFFFE}) {          // not a controlword
    EXPECT_EQ(bench.write_word(kBob, word), kLocalControl) << word;
  }
  EXPECT_EQ(bench.write(kBob, 1, 0x607A, 0).objects[0].abort_code, kLocalControl);
  EXPECT_EQ(bench.value(1, 0x6040), MovingAxis::kNewSetPoint);
  EXPECT_TRUE(bench.events(msg::EventKind::stopped).empty());
}

TEST(AcquireRequest, ReportsTheAxisThatItsSessionDidNotHaveYet) {
  EngineUnderTest bench;
  bench.reply_to(bench.make_request(msg::RequestKind::acquire, kAlice, {1}));
  bench.events(msg::EventKind::control_changed);
  bench.reply_to(bench.make_request(msg::RequestKind::acquire, kAlice, {1, 2}));
  const auto changes = bench.events(msg::EventKind::control_changed);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].axis, 2);
}

TEST(QuickStopOfAFreeAxis, NeitherNeedsNorAcquiresControl) {
  MovingAxis bench;
  bench.reply_to(bench.make_request(msg::RequestKind::release, kAlice, {1}));
  bench.events(msg::EventKind::control_changed);
  EXPECT_EQ(bench.write_word(0, 0x02), msg::Reason::none);
  bench.steps(1);
  EXPECT_EQ(bench.state(), MovingAxis::kQuickStopActive);
  EXPECT_EQ(bench.owner(), 0U);
  EXPECT_TRUE(bench.events(msg::EventKind::control_changed).empty());
  EXPECT_TRUE(bench.events(msg::EventKind::stopped).empty()) << "it has no owner";
}

TEST(AcquireRequest, GivesAxesAndAnEpoch) {
  EngineUnderTest bench;
  const auto first = bench.acquire(kAlice, {1, 2});
  EXPECT_EQ(first.reason, msg::Reason::none);
  const auto second = bench.acquire(kAlice, {3});
  EXPECT_GT(second.epoch, first.epoch) << "more axes renew the epoch for all";
  EXPECT_EQ(bench.acquire(kAlice, {1, 2, 3}).epoch, second.epoch) << "nothing was gained";
}

TEST(AcquireRequest, OfAnOwnedAxisAcquiresNothing) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {2});
  const auto reply = bench.acquire(kBob, {1, 2});
  EXPECT_EQ(reply.reason, kLocalControl);
  EXPECT_EQ(reply.refused_axis, 2U);
  EXPECT_EQ(reply.owner_session, kAlice);
  EXPECT_EQ(reply.epoch, 0U);
  EXPECT_EQ(bench.acquire(kAlice, {1}).reason, msg::Reason::none);
}

TEST(AcquireRequest, NeedsASessionAndAxes) {
  EngineUnderTest bench;
  EXPECT_EQ(bench.acquire(0, {1}).reason, msg::Reason::bad_session);
  EXPECT_EQ(bench.acquire(kAlice, {}).reason, msg::Reason::nothing_done);
  const auto unknown = bench.acquire(kAlice, {1, 77});
  EXPECT_EQ(unknown.reason, msg::Reason::unknown_axis);
  EXPECT_EQ(unknown.refused_axis, 77U);
}

TEST(TakeOverRequest, TakesControlAtOnceAndEndsTheOldEpoch) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  auto frame = bench.make_frame(kAlice);
  const auto reply = bench.reply_to(bench.make_request(msg::RequestKind::take_over, kBob, {1}));
  EXPECT_EQ(reply.reason, msg::Reason::none);
  EXPECT_NE(reply.epoch, 0U);
  set_controlword(add_command(frame, 1), 0x0F);
  bench.receive(frame);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::stale_epoch);
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6041), 0x250);
}

TEST(ReleaseRequest, DoesNotChangeTheAxis) {
  EngineUnderTest bench;
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.steps(2);
  const auto reply = bench.reply_to(bench.make_request(msg::RequestKind::release, kAlice));
  EXPECT_EQ(reply.reason, msg::Reason::none);
  EXPECT_EQ(reply.epoch, 0U);
  bench.steps(500);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x27);
  EXPECT_EQ(bench.write(kBob, 1, 0x6040, 0x06).objects[0].abort_code, msg::Reason::none);
}

TEST(ReleaseRequest, OfSomeAxesRenewsTheEpochOfTheOthers) {
  EngineUnderTest bench;
  const auto acquired = bench.acquire(kAlice, {1, 2});
  const auto reply = bench.reply_to(bench.make_request(msg::RequestKind::release, kAlice, {1}));
  EXPECT_GT(reply.epoch, acquired.epoch);
  EXPECT_EQ(bench.acquire(kBob, {1}).reason, msg::Reason::none);
  EXPECT_EQ(bench.acquire(kBob, {2}).reason, kLocalControl);
}

TEST(ReleaseRequest, OfAnAxisThatIsNotOwnedIsRefused) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  const auto reply = bench.reply_to(bench.make_request(msg::RequestKind::release, kAlice, {1, 2}));
  EXPECT_EQ(reply.reason, msg::Reason::not_owner);
  EXPECT_EQ(reply.refused_axis, 2U);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::release, kBob)).reason,
            msg::Reason::nothing_done);
}

TEST(PowerCycleRequest, NeedsAFreeAxisOrItsOwner) {
  EngineUnderTest bench;
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.write(kAlice, 1, 0x6081, 777);
  bench.steps(1);
  const auto stranger =
      bench.reply_to(bench.make_request(msg::RequestKind::power_cycle, kBob, {1}));
  EXPECT_EQ(stranger.reason, kLocalControl);
  const auto owner = bench.reply_to(bench.make_request(msg::RequestKind::power_cycle, kAlice, {1}));
  EXPECT_EQ(owner.reason, msg::Reason::none);
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6041), 0x250);
  EXPECT_EQ(bench.value(1, 0x6081), 68'267);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::power_cycle, kBob, {2})).reason,
            msg::Reason::none);
}

TEST(StoreRequest, IsRefusedWithoutAStateDirectory) {
  EngineUnderTest bench;
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::store, kAlice, {1})).reason,
            msg::Reason{0x08000020});
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::restore, kAlice, {1})).reason,
            msg::Reason{0x08000020});
}

TEST(Request, OfAnUnknownKindOrIncarnationIsRefused) {
  EngineUnderTest bench;
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind{0}, kAlice)).reason,
            msg::Reason::unknown_kind);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind{0xFFFFFFFF}, kAlice)).reason,
            msg::Reason::unknown_kind);
  auto other = bench.make_request(msg::RequestKind::read, kAlice);
  other.incarnation = kIncarnation + 1;
  EXPECT_EQ(bench.reply_to(other).reason, msg::Reason::wrong_incarnation);
  auto nobody = bench.make_request(msg::RequestKind::read, kAlice);
  nobody.client = 0;
  EXPECT_EQ(bench.reply_to(nobody).reason, msg::Reason::bad_session);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::read, kAlice)).reason,
            msg::Reason::nothing_done);
}

/// @return why a request of this kind is refused in this clock mode.
msg::Reason refusal_of_request(const wire::RequestKindRow& row, service::ClockMode mode) {
  switch (row.clock) {
    case wire::RequestClock::lockstep:
      return mode == service::ClockMode::lockstep ? msg::Reason::none
                                                  : msg::Reason::wrong_clock_mode;
    case wire::RequestClock::realtime:
      return mode == service::ClockMode::realtime ? msg::Reason::none
                                                  : msg::Reason::wrong_clock_mode;
    case wire::RequestClock::standing:
      return mode == service::ClockMode::lockstep ? msg::Reason::none : msg::Reason::time_passes;
    default:
      return msg::Reason::none;
  }
}

TEST(Request, IsRefusedInAClockModeThatTheRowOfItsKindDoesNotAllow) {
  for (const auto mode :
       {service::ClockMode::realtime, service::ClockMode::lockstep, service::ClockMode::freerun}) {
    auto configuration = bench_configuration(1);
    configuration.clock = mode;
    EngineUnderTest bench(configuration);
    for (const wire::RequestKindRow& row : wire::kRequestKinds) {
      const msg::Reason due = refusal_of_request(row, mode);
      // StepRequests handles these instead of the engine.
      if (due == msg::Reason::none && service::StepRequests::is_for(row.kind)) continue;
      auto request = bench.make_request(row.kind, kAlice);
      request.rate = configuration.rate;
      const msg::Reason reason = bench.reply_to(request).reason;
      SCOPED_TRACE(wire::value_row(row.kind)->name);
      if (due != msg::Reason::none) {
        EXPECT_EQ(reason, due);
      } else {
        EXPECT_NE(reason, msg::Reason::wrong_clock_mode);
        EXPECT_NE(reason, msg::Reason::time_passes);
      }
    }
  }
}

TEST(Request, NeedsASessionWhereTheRowOfItsKindSaysSo) {
  EngineUnderTest bench;
  for (const wire::RequestKindRow& row : wire::kRequestKinds) {
    auto request = bench.make_request(row.kind, 0, {77});  // the session is checked before the axes
    const bool is_refused = bench.reply_to(request).reason == msg::Reason::bad_session;
    EXPECT_EQ(is_refused, row.caller == wire::RequestCaller::session)
        << wire::value_row(row.kind)->name;
  }
}

TEST(Request, GetsTheReasonThatIsCheckedFirst) {
  auto configuration = bench_configuration(1);
  configuration.clock = service::ClockMode::realtime;
  EngineUnderTest bench(configuration);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::join_clock, 0, {77})).reason,
            msg::Reason::wrong_clock_mode);
  auto restore = bench.make_request(msg::RequestKind::restore_snapshot, kAlice);
  restore.snapshot = 7;
  EXPECT_EQ(bench.reply_to(restore).reason, msg::Reason::time_passes);
  configuration.clock = service::ClockMode::freerun;
  EngineUnderTest freerun(configuration);
  auto rate = freerun.make_request(msg::RequestKind::set_rate, kAlice);
  rate.rate = -1;
  EXPECT_EQ(freerun.reply_to(rate).reason, msg::Reason::wrong_clock_mode);
}

TEST(Request, OfAnotherBenchIsNotAnswered) {
  EngineUnderTest bench;
  auto request = bench.make_request(msg::RequestKind::read, kAlice);
  request.bench = kBench + 1;
  bench.receive(request);
  EXPECT_EQ(bench.outbox.replies.front(), nullptr);
}

TEST(Request, BeyondTheBoundsIsAnswered) {
  EngineUnderTest bench;
  auto objects = bench.make_request(msg::RequestKind::read, kAlice);
  objects.objects.resize(msg::MAX_OBJECTS_PER_REQUEST + 1);
  EXPECT_EQ(bench.reply_to(objects).reason, msg::Reason::too_many_objects);
  auto axes = bench.make_request(msg::RequestKind::acquire, kAlice,
                                 std::vector<std::uint16_t>(msg::MAX_AXES_PER_FRAME + 1, 1));
  EXPECT_EQ(bench.reply_to(axes).reason, msg::Reason::too_many_axes);
}

TEST(Inbox, RefusesMessagesAboveItsCapacityAndRemembersTheirSenders) {
  EngineUnderTest bench;
  const auto request = bench.make_request(msg::RequestKind::read, kAlice);
  for (std::size_t count = 0; count < service::InboxWriter::kCapacity + 3; ++count) {
    bench.inbox.receive(request, {});
  }
  EXPECT_EQ(bench.counters.queue_overflows.get(), 3U);
  const auto away = bench.inbox.next_turned_away();
  ASSERT_TRUE(away.has_value());
  EXPECT_EQ(away->request_id, request.request_id);
}

}  // namespace
}  // namespace vdrive::test

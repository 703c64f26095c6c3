// SPDX-License-Identifier: Apache-2.0
// Requests that store parameters: REQUEST_STORE, REQUEST_RESTORE, and 1010h and 1011h as objects.
#include "base/event_codes.hpp"
#include "core/support/allocation_guard.hpp"
#include "service/engine_under_test.hpp"
#include "service/failing_files.hpp"
#include "store/parameter_saver.hpp"
#include "support/temporary_directory.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <memory>
#include <vector>

namespace vdrive::test {
namespace {

constexpr msg::Reason kCannotStore{0x08000020};
constexpr msg::Reason kHardwareError{0x06060000};
constexpr msg::Reason kNotInAFrame{0x06040041};
constexpr std::int64_t kSave = 0x65766173;
constexpr std::int64_t kLoad = 0x64616F6C;

/// An engine with a state directory. Its saver runs when the test calls it.
struct StoringBench : EngineUnderTest {
  explicit StoringBench(const service::Configuration& with = bench_configuration(3))
      : EngineUnderTest(with),
        saver(std::make_unique<service::ParameterStore>(directory.path(), kBench,
                                                        std::make_unique<FailingFiles>(plan)),
              {}) {
    engine.store_with(saver);
  }

  /// Sends a request whose reply has to wait for the saver.
  msg::Request begin(msg::RequestKind kind, std::vector<std::uint16_t> axes,
                     std::uint64_t session = kAlice) {
    auto request = make_request(kind, session, std::move(axes));
    receive(request);
    EXPECT_EQ(outbox.replies.front(), nullptr) << "answered before it is durable";
    return request;
  }

  /// Runs the saver. @return the reply that has waited.
  msg::Reply finish() {
    saver.save_waiting();
    while (engine.answer_stores()) {
    }
    service::OutgoingReply* const outgoing = outbox.replies.front();
    if (outgoing == nullptr) {
      ADD_FAILURE() << "no reply";
      return {};
    }
    msg::Reply reply = outgoing->reply;
    outbox.replies.pop();
    return reply;
  }

  void power_cycle(std::uint16_t axis) {
    EXPECT_EQ(reply_to(make_request(msg::RequestKind::power_cycle, kAlice, {axis})).reason,
              msg::Reason::none);
  }

  TemporaryDirectory directory;
  FilePlan plan;
  service::ParameterSaver saver;
};

msg::ObjectAccess& add_object(msg::Request& request, std::uint16_t axis, std::uint16_t index,
                              std::uint8_t subindex, std::int64_t value) {
  auto& object = request.objects.emplace_back();
  object.axis = axis;
  object.index = index;
  object.subindex = subindex;
  object.value = value;
  return object;
}

TEST(StoreRequest, IsAnsweredAfterTheSaveAndTakesEffectAtAPowerCycle) {
  StoringBench bench;
  bench.write(kAlice, 1, 0x6081, 4'321);
  bench.write(kAlice, 2, 0x6081, 1'234);
  const auto request = bench.begin(msg::RequestKind::store, {1});
  bench.write(kAlice, 1, 0x6081, 9);  // after the store
  bench.steps(3);
  EXPECT_EQ(bench.outbox.replies.front(), nullptr);
  const auto reply = bench.finish();
  EXPECT_EQ(reply.request_id, request.request_id);
  EXPECT_EQ(reply.reason, msg::Reason::none);
  EXPECT_EQ(reply.tick, 3U);
  EXPECT_EQ(bench.value(1, 0x6081), 9) << "storing changes no value";
  bench.power_cycle(1);
  bench.power_cycle(2);
  EXPECT_EQ(bench.value(1, 0x6081), 4'321);
  EXPECT_EQ(bench.value(2, 0x6081), 68'267) << "not stored: the default";
}

TEST(StoreRequest, OfManyAxesHasOneAnswer) {
  StoringBench bench(bench_configuration(40));  // more than one tick handles
  std::vector<std::uint16_t> axes;
  for (std::uint16_t axis = 1; axis <= 40; ++axis) {
    axes.push_back(axis);
    bench.write(kAlice, axis, 0x6081, 1'000 + axis);
  }
  bench.begin(msg::RequestKind::store, axes);
  EXPECT_EQ(bench.finish().reason, msg::Reason::none);
  EXPECT_EQ(bench.outbox.replies.front(), nullptr);
  bench.power_cycle(40);
  EXPECT_EQ(bench.value(40, 0x6081), 1'040);
}

// A step is answered after its ticks, and stores are answered during them.
TEST(StoreRequest, LeavesRoomForTheAnswerOfARunningStep) {
  StoringBench bench;
  auto& replies = bench.outbox.replies;
  for (int count = 0; count < 8; ++count) {
    bench.receive(bench.make_request(msg::RequestKind::store, kAlice, {1}));
  }
  bench.saver.save_waiting();
  while (replies.size() + 4 < replies.capacity()) {
    bench.receive(bench.make_request(msg::RequestKind::read, kAlice));
  }
  ASSERT_TRUE(bench.engine.can_answer());
  service::StepRequests& steps = bench.engine.steps();
  const service::StepRequests::Time now{};
  service::Arrival step;
  step.kind = service::Arrival::Kind::request;
  step.request = bench.make_request(msg::RequestKind::step, kAlice);
  step.request.ticks = 10;
  const std::uint64_t number = step.request.request_id;
  steps.handle(step, now);
  ASSERT_EQ(steps.ticks_to_run(now), 10U);
  bench.steps(10);
  EXPECT_TRUE(steps.answer_due(now));
  ASSERT_EQ(replies.size(), replies.capacity());
  while (replies.size() > 1) replies.pop();
  EXPECT_EQ(replies.front()->reply.request_id, number);
  replies.pop();
  int later = 0;
  while (bench.engine.answer_stores()) ++later;
  EXPECT_GT(later, 0) << "nothing waited";
}

TEST(StoreRequest, NeedsExistingAxesThatNoOtherSessionHolds) {
  StoringBench bench;
  bench.acquire(kBob, {2});
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::store, kAlice)).reason,
            msg::Reason::nothing_done);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::store, kAlice, {1, 9})).reason,
            msg::Reason::unknown_axis);
  const auto reply = bench.reply_to(bench.make_request(msg::RequestKind::store, kAlice, {1, 2}));
  EXPECT_EQ(reply.reason, kLocalControl);
  EXPECT_EQ(reply.refused_axis, 2U);
  EXPECT_FALSE(bench.saver.save_waiting()) << "of a refused request nothing is stored";
}

TEST(StoreRequest, KeepsTheStoredValuesOnFailure) {
  StoringBench bench;
  bench.write(kAlice, 1, 0x6081, 100);
  bench.begin(msg::RequestKind::store, {1});
  bench.finish();
  bench.write(kAlice, 1, 0x6081, 200);
  bench.begin(msg::RequestKind::store, {1, 2});
  bench.plan.set([](std::uint64_t) {
    fail_with(ENOSPC);
  });
  const auto reply = bench.finish();
  EXPECT_EQ(reply.reason, kHardwareError);
  EXPECT_EQ(reply.refused_axis, 1U);
  bool has_event = false;
  while (const auto* const event = bench.outbox.events.front()) {
    has_event = has_event || (event->kind == msg::EventKind::parameters &&
                              event->code == service::ParameterCode::kSaveFailed &&
                              event->detail == service::EventDetail{service::SystemError{ENOSPC}} &&
                              event->axis == 1);
    bench.outbox.events.pop();
  }
  EXPECT_TRUE(has_event);
  bench.power_cycle(1);
  EXPECT_EQ(bench.value(1, 0x6081), 100);
}

TEST(RestoreRequest, SetsTheConfiguredValuesAtThePowerCycle) {
  auto configuration = bench_configuration(1);
  configuration.axes[0].configuration.parameters = {{{0x6081, 0}, 777}};
  StoringBench bench(configuration);
  bench.write(kAlice, 1, 0x6081, 100);
  bench.begin(msg::RequestKind::store, {1});
  bench.finish();
  bench.begin(msg::RequestKind::restore, {1});
  EXPECT_EQ(bench.finish().reason, msg::Reason::none);
  EXPECT_EQ(bench.value(1, 0x6081), 100) << "in force after the next power cycle";
  bench.power_cycle(1);
  EXPECT_EQ(bench.value(1, 0x6081), 777);
}

TEST(StoreObject, ActsLikeTheStoreRequest) {
  StoringBench bench;
  EXPECT_EQ(bench.value(1, 0x1010, 1), 1);
  auto request = bench.make_request(msg::RequestKind::write, kAlice);
  add_object(request, 1, 0x6081, 0, 55);
  add_object(request, 1, 0x1010, 1, kSave);
  add_object(request, 1, 0x6081, 0, 66);  // after the store: not stored
  add_object(request, 2, 0x1010, 1, kLoad);
  bench.receive(request);
  EXPECT_EQ(bench.outbox.replies.front(), nullptr);
  const auto reply = bench.finish();
  ASSERT_EQ(reply.objects.size(), 4U);
  EXPECT_EQ(reply.reason, msg::Reason::none);
  EXPECT_EQ(reply.objects[1].abort_code, msg::Reason::none);
  EXPECT_EQ(reply.objects[3].abort_code, kCannotStore) << "the other's signature";
  bench.power_cycle(1);
  EXPECT_EQ(bench.value(1, 0x6081), 55);

  auto restore = bench.make_request(msg::RequestKind::write, kAlice);
  add_object(restore, 1, 0x1011, 1, kLoad);
  bench.receive(restore);
  EXPECT_EQ(bench.finish().objects.at(0).abort_code, msg::Reason::none);
  bench.power_cycle(1);
  EXPECT_EQ(bench.value(1, 0x6081), 68'267);
}

TEST(StoreObject, IsRefusedAtOnceWithAWrongSignatureOrWithoutAStateDirectory) {
  StoringBench bench;
  EXPECT_EQ(bench.write(kAlice, 1, 0x1010, 1, 1).objects.at(0).abort_code, kCannotStore);
  EXPECT_EQ(bench.write(kAlice, 1, 0x1011, kSave, 1).objects.at(0).abort_code, kCannotStore);
  EngineUnderTest without;
  EXPECT_EQ(without.write(kAlice, 1, 0x1010, kSave, 1).objects.at(0).abort_code, kCannotStore);
  EXPECT_EQ(without.value(1, 0x1010, 1), 1);
}

TEST(StoreObject, ReportsAFailureAsItsOwnAbortCode) {
  StoringBench bench;
  auto request = bench.make_request(msg::RequestKind::write, kAlice);
  add_object(request, 1, 0x6081, 0, 55);
  add_object(request, 1, 0x1010, 1, kSave);
  bench.receive(request);
  bench.plan.set([](std::uint64_t) {
    fail_with(EIO);
  });
  const auto reply = bench.finish();
  EXPECT_EQ(reply.reason, msg::Reason::none);
  EXPECT_EQ(reply.objects.at(0).abort_code, msg::Reason::none);
  EXPECT_EQ(reply.objects.at(1).abort_code, kHardwareError);
}

TEST(StoreObject, IsRefusedInACommandFrame) {
  StoringBench bench;
  bench.acquire(kAlice, {1});
  auto frame = bench.make_frame(kAlice);
  auto& object = add_command(frame, 1).objects.emplace_back();
  object.index = 0x1010;
  object.subindex = 1;
  object.value = kSave;
  bench.receive(frame);
  const auto reply = bench.command_reply();
  ASSERT_TRUE(reply);
  ASSERT_EQ(reply->refusals.size(), 1U);
  EXPECT_EQ(reply->refusals[0].reason, kNotInAFrame);
  EXPECT_FALSE(bench.saver.save_waiting());
}

TEST(StoreRequest, IsRefusedWhileTooManyWait) {
  StoringBench bench;
  std::size_t accepted = 0;
  for (;; ++accepted) {
    bench.receive(bench.make_request(msg::RequestKind::store, kAlice, {1, 2, 3}));
    if (bench.outbox.replies.front() != nullptr) break;
  }
  EXPECT_EQ(bench.outbox.replies.front()->reply.reason, msg::Reason::queue_full);
  bench.outbox.replies.pop();
  EXPECT_GE(accepted, 600U);
  bench.saver.save_waiting();
  std::size_t answered = 0;
  for (int tick = 0; tick < 10'000 && answered < accepted; ++tick) {
    bench.steps(1);
    while (bench.outbox.replies.front() != nullptr) {
      EXPECT_EQ(bench.outbox.replies.front()->reply.reason, msg::Reason::none);
      bench.outbox.replies.pop();
      ++answered;
    }
  }
  EXPECT_EQ(answered, accepted);
  bench.begin(msg::RequestKind::store, {1});
  EXPECT_EQ(bench.finish().reason, msg::Reason::none);
}

TEST(StoreRequest, AllocatesNothingInTheSteppingThread) {
  StoringBench bench;
  const auto request = bench.make_request(msg::RequestKind::store, kAlice, {1, 2, 3});
  const auto store = [&] {
    bench.inbox.receive(request, {});
    std::uint64_t allocations = 0;
    {
      const AllocationGuard guard;
      bench.engine.handle(*bench.inbox.front());
      bench.inbox.pop();
      allocations += guard.count();
    }
    bench.saver.save_waiting();
    {
      const AllocationGuard guard;
      bench.engine.step();
      allocations += guard.count();
    }
    bench.outbox.replies.pop();
    return allocations;
  };
  store();
  EXPECT_EQ(store(), 0U);
}

TEST(StoredParameters, StayAfterARestoredSnapshot) {
  StoringBench bench;
  const auto taken = bench.reply_to(bench.make_request(msg::RequestKind::take_snapshot, kAlice));
  bench.write(kAlice, 1, 0x6081, 100);
  bench.begin(msg::RequestKind::store, {1});
  bench.finish();
  auto restore = bench.make_request(msg::RequestKind::restore_snapshot, kAlice);
  restore.snapshot = taken.snapshot;
  EXPECT_EQ(bench.reply_to(restore).reason, msg::Reason::none);
  EXPECT_EQ(bench.value(1, 0x6081), 68'267);
  bench.power_cycle(1);
  EXPECT_EQ(bench.value(1, 0x6081), 100);
}

}  // namespace
}  // namespace vdrive::test

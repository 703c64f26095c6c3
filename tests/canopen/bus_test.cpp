// SPDX-License-Identifier: Apache-2.0
#include "bus/bus.hpp"

#include "canopen/recorded_port.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

/// A port that calls a function for each frame it receives.
class ActingPort final : public Port {
 public:
  explicit ActingPort(std::function<void(const Frame&)> act) : act_(std::move(act)) {}

  void deliver(const Frame& frame) override {
    frames.push_back(frame);
    act_(frame);
  }

  Frames frames;

 private:
  std::function<void(const Frame&)> act_;
};

const Frame kFirst = data_frame(0x181, {1});
const Frame kSecond = data_frame(0x182, {2});

TEST(Bus, DeliversAFrameToEveryPortButItsSender) {
  Bus bus;
  RecordedPort sender(bus);
  RecordedPort near(bus);
  RecordedPort far(bus);
  sender.send(kFirst);
  EXPECT_EQ(sender.frames, Frames{});
  EXPECT_EQ(near.frames, Frames{kFirst});
  EXPECT_EQ(far.frames, Frames{kFirst});
}

TEST(Bus, DeliversAFrameWithoutASenderToAll) {
  Bus bus;
  RecordedPort port(bus);
  bus.send(kFirst, nullptr);
  EXPECT_EQ(port.frames, Frames{kFirst});
}

/// A port that counts its resume() calls.
class ResumingPort final : public Port {
 public:
  void deliver(const Frame& /*frame*/) override {}

  void resume() override { ++resumed; }

  int resumed = 0;
};

TEST(Bus, ResumesAllPortsWhenTheLastOneReleasesIt) {
  Bus bus;
  ResumingPort slow;
  ResumingPort slower;
  bus.attach(slow);
  bus.attach(slower);
  bus.hold(slow);
  bus.hold(slow);
  bus.hold(slower);
  bus.release(slow);
  EXPECT_TRUE(bus.is_held());
  EXPECT_EQ(slow.resumed, 0);
  bus.release(slower);
  EXPECT_FALSE(bus.is_held());
  EXPECT_EQ(slow.resumed, 1);
  EXPECT_EQ(slower.resumed, 1);
  bus.release(slower);
  EXPECT_EQ(slow.resumed, 1) << "nobody held it";
}

TEST(Bus, IsNotHeldByAPortThatIsDetached) {
  Bus bus;
  ResumingPort slow;
  ResumingPort other;
  bus.attach(slow);
  bus.attach(other);
  bus.hold(slow);
  bus.detach(slow);
  EXPECT_FALSE(bus.is_held());
  EXPECT_EQ(other.resumed, 1);
}

TEST(Bus, CountsFramesWithAndWithoutReceivers) {
  Bus bus;
  bus.send(kFirst, nullptr);
  RecordedPort port(bus);
  bus.send(kSecond, nullptr);
  EXPECT_EQ(bus.frames(), 2U);
}

TEST(Bus, KeepsOneOrderForAllWhenAPortAnswersWithinADelivery) {
  Bus bus;
  RecordedPort before(bus);
  ActingPort answering([&](const Frame& frame) {
    if (frame == kFirst) bus.send(kSecond, &answering);
  });
  bus.attach(answering);
  RecordedPort after(bus);
  bus.send(kFirst, nullptr);
  // The answer follows the frame also for `after`, which receives frames last.
  EXPECT_EQ(before.frames, (Frames{kFirst, kSecond}));
  EXPECT_EQ(after.frames, (Frames{kFirst, kSecond}));
  EXPECT_EQ(answering.frames, Frames{kFirst});
  EXPECT_EQ(bus.frames(), 2U);
}

TEST(Bus, GivesADetachedPortNothingMore) {
  Bus bus;
  auto port = std::make_unique<RecordedPort>(bus);
  bus.send(kFirst, nullptr);
  EXPECT_EQ(port->frames, Frames{kFirst});
  port.reset();
  bus.send(kSecond, nullptr);
  EXPECT_EQ(bus.frames(), 2U);
}

TEST(Bus, GivesAPortThatIsDetachedWithinADeliveryNothingMore) {
  Bus bus;
  std::unique_ptr<RecordedPort> victim;
  ActingPort cutting([&victim](const Frame&) {
    victim.reset();
  });
  bus.attach(cutting);
  victim = std::make_unique<RecordedPort>(bus);
  RecordedPort last(bus);
  bus.send(kFirst, nullptr);  // would reach a dangling port
  bus.send(kSecond, nullptr);
  EXPECT_EQ(last.frames, (Frames{kFirst, kSecond}));
}

TEST(Bus, LetsAPortDetachItselfWithinADelivery) {
  Bus bus;
  ActingPort leaving([&](const Frame&) {
    bus.detach(leaving);
  });
  bus.attach(leaving);
  RecordedPort last(bus);
  bus.send(kFirst, nullptr);
  bus.send(kSecond, nullptr);
  EXPECT_EQ(leaving.frames, Frames{kFirst});
  EXPECT_EQ(last.frames, (Frames{kFirst, kSecond}));
}

TEST(Bus, DeliversAWaitingFrameOfAPortThatHasGone) {
  Bus bus;
  RecordedPort receiver(bus);
  ActingPort leaving([&](const Frame&) {
    bus.send(kSecond, &leaving);
    bus.detach(leaving);
  });
  bus.attach(leaving);
  bus.send(kFirst, nullptr);
  EXPECT_EQ(receiver.frames, (Frames{kFirst, kSecond}));
  EXPECT_EQ(leaving.frames, Frames{kFirst});
}

TEST(Bus, GivesAPortThatIsAttachedWithinADeliveryTheNextFrameFirst) {
  Bus bus;
  std::unique_ptr<RecordedPort> added;
  ActingPort adding([&](const Frame&) {
    if (!added) added = std::make_unique<RecordedPort>(bus);
  });
  bus.attach(adding);
  bus.send(kFirst, nullptr);
  bus.send(kSecond, nullptr);
  ASSERT_NE(added, nullptr);
  EXPECT_EQ(added->frames, Frames{kSecond});
}

// Two nodes answer each other endlessly if each has the other's TPDO as its SYNC.
TEST(Bus, EndsPortsThatAnswerEachOtherAndCountsWhatItDrops) {
  Bus bus;
  ActingPort one([&](const Frame&) {
    bus.send(kFirst, &one);
  });
  ActingPort two([&](const Frame&) {
    bus.send(kSecond, &two);
  });
  bus.attach(one);
  bus.attach(two);
  bus.send(kSecond, &two);
  EXPECT_EQ(bus.frames(), Bus::kMostAtOnce);
  EXPECT_EQ(bus.dropped_frames(), 1U);
  bus.detach(two);
  bus.send(kSecond, nullptr);
  EXPECT_EQ(one.frames.back(), kSecond) << "the next frame is delivered";
  EXPECT_EQ(bus.dropped_frames(), 1U);
}

TEST(Bus, IgnoresTheDetachmentOfAPortThatIsNotThere) {
  Bus bus;
  RecordedPort port(bus);
  ActingPort stranger([](const Frame&) {});
  bus.detach(stranger);
  bus.send(kFirst, nullptr);
  EXPECT_EQ(port.frames, Frames{kFirst});
}

}  // namespace
}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
#include "guard/silent_readers.hpp"

#include "datagrams.hpp"
#include "guard/datagram_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::wire {
namespace {

using namespace std::chrono_literals;
using test::kSender;
using test::kUserReader;
using test::kUserWriter;
using testing::IsEmpty;
using testing::SizeIs;

constexpr EntityId kOtherWriter = 0x00000303;

test::Datagram acknack_from(const GuidPrefix& sender, std::int64_t base) {
  return test::DatagramWriter(sender)
      .add(0x06, 1, test::acknack(kUserReader, kUserWriter, base).bytes())
      .bytes();
}

struct ASilentReader : testing::Test {
  SilentReaders<int> readers;
  SilentReaders<int>::Clock::time_point now{1h};

  ASilentReader() { readers.found(kSender); }

  void acknowledges(std::int64_t base) { readers.received(acknack_from(kSender, base), 7); }

  void sends_up_to(std::int64_t last, EntityId writer = kUserWriter) {
    readers.sends(test::DatagramWriter({})
                      .add(0x07, 1, test::heartbeat(kUserReader, writer, 1, last).bytes())
                      .bytes());
  }

  /// Checks every 100 ms. @return the acknowledgements that became due in that time
  std::vector<SilentReaders<int>::Acknowledgement> after(std::chrono::milliseconds time) {
    std::vector<SilentReaders<int>::Acknowledgement> due;
    for (auto gone = 0ms; gone < time; gone += 100ms) {
      now += 100ms;
      for (auto& each : readers.take_due(now)) due.push_back(std::move(each));
    }
    return due;
  }
};

TEST_F(ASilentReader, IsAcknowledgedForWhenItOwesAnAnswerForTooLong) {
  acknowledges(5);
  sends_up_to(9);
  // The first check notes the debt.
  EXPECT_THAT(after(kPatienceWithVdrive), IsEmpty());
  const auto due = after(100ms);
  ASSERT_THAT(due, SizeIs(1));
  EXPECT_EQ(due[0].channel, 7);
  EXPECT_EQ(check_datagram(due[0].datagram, Mode::open).refusal, Refusal::none);
  // As the reader would have written it: all up to 9 arrived, and the count after its last one, 1.
  test::Body words;
  words.entity(kUserReader).entity(kUserWriter).sequence(10).u32(0).u32(2);
  EXPECT_EQ(due[0].datagram, test::DatagramWriter(kSender).add(0x06, 3, words.bytes()).bytes());
  EXPECT_THAT(after(1s), IsEmpty()) << "all is acknowledged";
  sends_up_to(12);
  EXPECT_THAT(after(100ms), SizeIs(1)) << "it is silent since then";
}

TEST_F(ASilentReader, IsNoneThatOwesNothing) {
  acknowledges(10);
  sends_up_to(9);
  EXPECT_THAT(after(10s), IsEmpty());
}

TEST_F(ASilentReader, IsNoneWhoseParticipantSaysAnything) {
  acknowledges(5);
  sends_up_to(9);
  for (int time = 0; time < 10; ++time) {
    EXPECT_THAT(after(kPatienceWithVdrive - 200ms), IsEmpty());
    readers.received(test::DatagramWriter(kSender)
                         .add(0x07, 1, test::heartbeat(kUserReader, kUserWriter, 1, 1).bytes())
                         .bytes(),
                     7);
  }
}

TEST_F(ASilentReader, IsNoneWhileThisProgramDidNotRun) {
  acknowledges(5);
  sends_up_to(9);
  EXPECT_THAT(after(1s), IsEmpty());
  now += 1h;
  EXPECT_THAT(after(kPatienceWithVdrive), IsEmpty());
  EXPECT_THAT(after(200ms), SizeIs(1));
}

TEST_F(ASilentReader, IsNoneOfAnotherWriter) {
  acknowledges(5);
  sends_up_to(9, kOtherWriter);
  EXPECT_THAT(after(10s), IsEmpty());
}

TEST_F(ASilentReader, IsForgottenWithItsParticipantAndItsChannel) {
  acknowledges(5);
  sends_up_to(9);
  readers.closed(7);
  EXPECT_THAT(after(10s), IsEmpty());
  acknowledges(5);
  readers.removed(kSender);
  EXPECT_THAT(after(10s), IsEmpty());
  acknowledges(5);
  EXPECT_THAT(after(10s), IsEmpty()) << "the library does not know it";
}

}  // namespace
}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
// Which sequence numbers of a writer the library may read, and which numbers replace them.
#include "guard/writer_numbers.hpp"

#include "wire/datagrams.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace vdrive::wire {
namespace {

using namespace std::chrono_literals;
using test::Body;
using test::data_to;
using test::Datagram;
using test::DatagramWriter;
using test::kSender;

constexpr test::GuidPrefix kAnother{1, 15, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12};
constexpr std::uint32_t kReader = test::kUserReader;
constexpr std::uint32_t kWriter = test::kUserWriter;
constexpr std::int64_t kReach = WriterNumbers::kReach;
constexpr std::int64_t kFar = std::int64_t{1} << 39U;
constexpr std::int64_t kLate = 1'000'000'000;

struct Part {
  std::uint8_t kind;
  Body body;
};

Datagram of(const std::vector<Part>& parts, const test::GuidPrefix& sender = kSender) {
  DatagramWriter datagram(sender);
  for (const Part& part : parts) datagram.add(part.kind, 1, part.body.bytes());
  return datagram.bytes();
}

Part heartbeat(std::int64_t first, std::int64_t last, std::uint32_t writer = kWriter) {
  return {0x07, test::heartbeat(kReader, writer, first, last)};
}

/// @return a GAP whose bit set is empty.
Part gap(std::int64_t start, std::int64_t base) {
  return {0x08, test::gap(kReader, kWriter, start, base)};
}

/// @return a GAP of only a bit set, the last bit of which is `last`.
Part set_up_to(std::int64_t last) {
  Body body;
  body.entity(kReader).entity(kWriter).sequence(last - 31).sequence(last - 31).u32(32).u32(~0U);
  return {0x08, body};
}

Part data(std::int64_t number, std::uint32_t writer = kWriter) {
  return {0x15, data_to(kReader, writer, number).raw({0, 1, 0, 0, 1, 2, 3, 4})};
}

Part fragment(std::int64_t number) {
  Body body = data_to(kReader, kWriter, number, 28);
  return {0x16, body.u32(1).u16(1).u16(64).u32(128).raw(Datagram(64))};
}

Part acknack(std::int64_t base) {
  return {0x06, test::acknack(kReader, kWriter, base)};
}

Part nack_frag(std::int64_t number) {
  return {0x12, Body().entity(kReader).entity(kWriter).sequence(number).u32(1).u32(0).u32(1)};
}

Part for_the_sender() {
  return {0x0E, Body().raw({kSender.begin(), kSender.end()})};
}

/// WriterNumbers for a participant that the library knows.
class Numbers {
 public:
  Numbers() { numbers_.found(kSender); }

  WriterNumbers::Report take(const std::vector<Part>& parts, std::chrono::milliseconds at = 0ms) {
    return take(of(parts), at);
  }

  WriterNumbers::Report take(const Datagram& datagram, std::chrono::milliseconds at = 0ms) {
    changed_.clear();
    return numbers_.receive(datagram, kStart + at, changed_);
  }

  Refusal refusal_of(const Part& part, std::chrono::milliseconds at = 0ms) {
    return take(std::vector{part}, at).refusal;
  }

  /// @return the datagram as the library reads it.
  Datagram read(const std::vector<Part>& parts) {
    const auto report = take(parts);
    EXPECT_EQ(describe(report.refusal), describe(Refusal::none));
    return report.is_renumbered ? changed_ : of(parts);
  }

  /// @return the datagram as it is sent.
  Datagram sent(const std::vector<Part>& parts) {
    changed_.clear();
    const Datagram datagram = of(parts, kAnother);
    return numbers_.send(datagram, changed_) ? changed_ : datagram;
  }

  WriterNumbers& operator*() { return numbers_; }

 private:
  static constexpr WriterNumbers::Clock::time_point kStart{std::chrono::hours{1}};

  WriterNumbers numbers_;
  Datagram changed_;
};

// ---- refusals -----------------------------------------------------------------------------------

struct Field {
  const char* name;
  std::int64_t largest;  ///< from a writer that has sent 100 samples, all acknowledged
  std::function<Part(std::int64_t)> part;
};

class NumberOfAWriter : public testing::TestWithParam<Field> {};

TEST_P(NumberOfAWriter, IsRefusedBeyondTheReachOfWhatItHasSent) {
  for (const std::int64_t beyond : {std::int64_t{0}, std::int64_t{1}, kFar}) {
    Numbers numbers;
    numbers.take({heartbeat(1, 100)});
    numbers.sent({for_the_sender(), acknack(101)});
    const Refusal expected = beyond == 0 ? Refusal::none : Refusal::jump;
    EXPECT_EQ(describe(numbers.refusal_of(GetParam().part(GetParam().largest + beyond))),
              describe(expected))
        << beyond;
  }
}

INSTANTIATE_TEST_SUITE_P(Fields, NumberOfAWriter,
                         testing::Values(
                             // 101 to 65,636 would be skipped.
                             Field{"FirstOfAHeartbeat", 101 + kReach,
                                   [](std::int64_t number) {
                                     return heartbeat(number, number - 1);
                                   }},
                             Field{"LastOfAHeartbeat", 100 + kReach,
                                   [](std::int64_t number) {
                                     return heartbeat(101, number);
                                   }},
                             Field{"StartOfAGap", 100 + kReach,
                                   [](std::int64_t number) {
                                     return gap(number, number + 1);
                                   }},
                             Field{"BaseOfAGap", 101 + kReach,
                                   [](std::int64_t number) {
                                     return gap(101, number);
                                   }},
                             Field{"SetOfAGap", 100 + kReach, set_up_to},
                             Field{"Data", 100 + kReach,
                                   [](std::int64_t number) {
                                     return data(number);
                                   }},
                             Field{"DataFrag", 100 + kReach, fragment}),
                         [](const auto& row) {
                           return std::string(row.param.name);
                         });

TEST(Heartbeat, SkipsNoMoreThanTheReachOfWhatIsAcknowledged) {
  Numbers numbers;
  // The oldest sample of this writer is its first.
  numbers.take({heartbeat(1, 1'000'000)});
  EXPECT_EQ(numbers.refusal_of(heartbeat(999'000, 1'000'000)), Refusal::jump);
  numbers.sent({for_the_sender(), acknack(999'000)});
  EXPECT_EQ(numbers.refusal_of(heartbeat(999'000, 1'000'000)), Refusal::none);
}

TEST(ForgedNumber, ChangesNothingForTheWriter) {
  Numbers numbers;
  numbers.take({heartbeat(1, 100)});
  for (int time = 0; time < 3; ++time) {
    EXPECT_EQ(numbers.refusal_of(data(kFar)), Refusal::jump);
    EXPECT_EQ(numbers.refusal_of(heartbeat(kFar, kFar)), Refusal::jump);
  }
  EXPECT_EQ(numbers.refusal_of(data(101)), Refusal::none);
  EXPECT_EQ(numbers.refusal_of(heartbeat(1, 101)), Refusal::none);
}

TEST(SkippedNumbers, AreLimitedInASecond) {
  Numbers numbers;
  numbers.take({heartbeat(1, 0)});
  std::int64_t first = 1;
  int accepted = 0;
  while (accepted < 100 &&
         numbers.refusal_of(heartbeat(first + kReach, first + kReach - 1)) == Refusal::none) {
    first += kReach;
    ++accepted;
  }
  // The limit of four times the reach is checked before each skip, so the fifth still passes.
  EXPECT_EQ(accepted, 5);
  EXPECT_EQ(numbers.refusal_of(heartbeat(first + kReach, first + kReach - 1)), Refusal::range);
  EXPECT_EQ(numbers.refusal_of(heartbeat(first + kReach, first + kReach - 1), 1s), Refusal::none);
}

TEST(GapNumbers, AreLimitedInASecond) {
  Numbers numbers;
  numbers.take({heartbeat(1, kReach)});
  for (int time = 0; time < 5; ++time) {
    EXPECT_EQ(numbers.refusal_of(gap(1, 1 + kReach)), Refusal::none);
  }
  EXPECT_EQ(numbers.refusal_of(gap(1, 1 + kReach)), Refusal::range);
}

TEST(WriterOfDiscovery, BeginsNearItsFirstSample) {
  constexpr std::int64_t kMost = WriterNumbers::kMostOfDiscovery;
  Numbers numbers;
  EXPECT_EQ(numbers.refusal_of(heartbeat(kMost, kMost + 1, test::kPublicationsWriter)),
            Refusal::jump);
  EXPECT_EQ(numbers.refusal_of(heartbeat(kMost, kMost, test::kPublicationsWriter)), Refusal::none);
  EXPECT_EQ(numbers.refusal_of(data(kMost + kReach + 1, test::kPublicationsWriter)), Refusal::jump);
}

// The end of a participant, as the guard itself announces it, has number 2^31 - 1.
TEST(AnnouncementOfAParticipant, MayHaveAnyNumber) {
  Numbers numbers;
  EXPECT_EQ(numbers.refusal_of(data(1, test::kParticipantsWriter)), Refusal::none);
  EXPECT_EQ(numbers.refusal_of(data(kFar, test::kParticipantsWriter)), Refusal::none);
  EXPECT_EQ(numbers.refusal_of(data(2, test::kParticipantsWriter)), Refusal::none);
}

TEST(WriterWithoutHeartbeats, MaySkipWhatAStandstillOfMinutesCosts) {
  Numbers numbers;
  EXPECT_EQ(numbers.refusal_of(data(kLate)), Refusal::none);
  EXPECT_EQ(numbers.refusal_of(data(kLate + WriterNumbers::kReachOfBestEffort)), Refusal::none);
  EXPECT_EQ(numbers.refusal_of(data(kFar)), Refusal::jump);
}

TEST(Participant, HasALimitedNumberOfWriters) {
  Numbers numbers;
  for (std::uint32_t number = 0; number < WriterNumbers::kMostWriters; ++number) {
    EXPECT_EQ(numbers.refusal_of(heartbeat(1, 1, (number << 8U) + 3)), Refusal::none);
  }
  EXPECT_EQ(numbers.refusal_of(heartbeat(1, 1, 0xFFFF03)), Refusal::jump);
  EXPECT_EQ(numbers.refusal_of(heartbeat(1, 1, 3)), Refusal::none);
}

// The library ignores the writers of such a participant as well.
TEST(Participant, ThatTheLibraryDoesNotKnowIsNotFollowed) {
  Numbers numbers;
  const Datagram datagram = of({heartbeat(kFar, kFar)}, kAnother);
  const auto report = numbers.take(datagram);
  EXPECT_EQ(report.refusal, Refusal::none);
  EXPECT_FALSE(report.is_renumbered);
}

TEST(Participant, MayBeNamedInAnotherOnesDatagram) {
  Numbers numbers;
  numbers.take({heartbeat(1, 1)});
  const Body source = Body().u32(0).raw({2, 3, 1, 15}).raw({kSender.begin(), kSender.end()});
  EXPECT_EQ(numbers.take(of({{0x0C, source}, heartbeat(kFar, kFar)}, kAnother)).refusal,
            Refusal::jump);
}

// ---- a writer that has sent much before it is heard ---------------------------------------------

TEST(WriterThatIsHeardEarly, KeepsItsNumbers) {
  Numbers numbers;
  EXPECT_EQ(numbers.read({heartbeat(WriterNumbers::kNear, 2'000)}),
            of({heartbeat(WriterNumbers::kNear, 2'000)}));
  EXPECT_EQ(numbers.read({data(2'001)}), of({data(2'001)}));
  EXPECT_EQ(numbers.sent({for_the_sender(), acknack(7)}),
            of({for_the_sender(), acknack(7)}, kAnother));
}

TEST(WriterThatIsHeardLate, BeginsAtItsPresentForTheLibrary) {
  Numbers numbers;
  EXPECT_EQ(numbers.read({heartbeat(kLate + 1, kLate)}), of({heartbeat(1, 0)}));
  EXPECT_EQ(numbers.read({data(kLate + 1)}), of({data(1)}));
  EXPECT_EQ(numbers.read({fragment(kLate + 2)}), of({fragment(2)}));
  EXPECT_EQ(numbers.read({gap(kLate + 3, kLate + 9), heartbeat(kLate + 1, kLate + 9)}),
            of({gap(3, 9), heartbeat(1, 9)}));
}

TEST(WriterThatIsHeardLate, IsAnsweredWithItsOwnNumbers) {
  Numbers numbers;
  numbers.take({heartbeat(kLate + 1, kLate + 5)});
  EXPECT_EQ(numbers.sent({for_the_sender(), nack_frag(2), acknack(2)}),
            of({for_the_sender(), nack_frag(kLate + 2), acknack(kLate + 2)}, kAnother));
  // 0 asks for a first heartbeat.
  EXPECT_EQ(numbers.sent({for_the_sender(), acknack(0)}),
            of({for_the_sender(), acknack(0)}, kAnother));
  // The same entity id of another participant is another writer.
  EXPECT_EQ(numbers.sent({acknack(2)}), of({acknack(2)}, kAnother));
}

TEST(WriterThatIsHeardLate, MayBeBigEndian) {
  Numbers numbers;
  // High half, then low half: 2^32 + 256 and 2^32 + 511.
  const Datagram first{0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 255};
  const Datagram read{0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0};
  const auto datagram = [](const Datagram& range) {
    const Datagram body = Body().entity(kReader).entity(kWriter).raw(range).u32(0).bytes();
    Datagram bytes = DatagramWriter(kSender).add(0x07, 0, body).bytes();
    std::swap(bytes.at(22), bytes.at(23));
    return bytes;
  };
  Datagram renumbered;
  EXPECT_TRUE((*numbers).receive(datagram(first), {}, renumbered).is_renumbered);
  EXPECT_EQ(renumbered, datagram(read));
}

// A volatile writer first tells a new reader that existing samples are not for it.
TEST(WriterThatIsHeardLate, MayBeginWithAGapBeforeItsHeartbeat) {
  Numbers numbers;
  EXPECT_EQ(numbers.read({gap(kLate + 5, kLate + 7), heartbeat(kLate + 1, kLate + 7)}),
            of({gap(5, 7), heartbeat(1, 7)}));
}

// The library has already read data with the original numbers, so it must find the sender again.
TEST(WriterThatIsHeardLate, WithoutItsFirstHeartbeatIsBegunAgain) {
  Numbers numbers;
  EXPECT_EQ(numbers.read({data(kLate)}), of({data(kLate)}));
  EXPECT_EQ(numbers.take({heartbeat(kLate - 1, kLate)}).needs_resync, kSender);
  (*numbers).removed(kSender);
  (*numbers).found(kSender);
  EXPECT_EQ(numbers.read({heartbeat(kLate - 1, kLate)}), of({heartbeat(1, 2)}));
}

TEST(WriterOfDataAlone, IsNotBegunAgainByOneHeartbeatThatIsFarFromThem) {
  Numbers numbers;
  numbers.take({data(kLate)});
  for (const std::int64_t number : {kLate - kReach - 1, kLate + kReach + 1, kFar}) {
    EXPECT_EQ(numbers.take({heartbeat(number, number)}).refusal, Refusal::jump) << number;
    EXPECT_EQ(numbers.take({heartbeat(number, number)}).needs_resync, std::nullopt) << number;
  }
  EXPECT_EQ(numbers.refusal_of(data(kLate + 1)), Refusal::none);
}

// ---- a writer that has continued without this program -------------------------------------------

TEST(WriterThatHasSkippedNumbers, IsBegunAgainAfterHalfASecond) {
  Numbers numbers;
  numbers.take({heartbeat(1, 100)});
  EXPECT_EQ(numbers.take({heartbeat(kLate, kLate)}).needs_resync, std::nullopt);
  EXPECT_EQ(numbers.take({heartbeat(kLate, kLate)}, 499ms).needs_resync, std::nullopt);
  EXPECT_EQ(numbers.take({heartbeat(kLate, kLate)}, 500ms).needs_resync, kSender);
}

TEST(WriterThatHasSkippedNumbers, IsBelievedOnlyWithoutAnotherWordFromIt) {
  Numbers numbers;
  numbers.take({heartbeat(1, 100)});
  numbers.take({heartbeat(kFar, kFar)});
  numbers.take({heartbeat(1, 100)}, 250ms);
  EXPECT_EQ(numbers.take({heartbeat(kFar, kFar)}, 500ms).needs_resync, std::nullopt);
  // The next one arrives more than 5 s later and counts as isolated.
  EXPECT_EQ(numbers.take({heartbeat(kFar, kFar)}, 5'501ms).needs_resync, std::nullopt);
}

// Numbers begun by a forger are not kept, because the writer itself contradicts them.
TEST(WriterThatAForgerBegan, IsBegunAgain) {
  Numbers numbers;
  numbers.take({heartbeat(kFar, kFar)});
  EXPECT_EQ(numbers.take({heartbeat(1, 100)}).refusal, Refusal::jump);
  EXPECT_EQ(numbers.take({heartbeat(1, 100)}, 500ms).needs_resync, kSender);
}

}  // namespace
}  // namespace vdrive::wire

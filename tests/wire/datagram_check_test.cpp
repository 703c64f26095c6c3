// SPDX-License-Identifier: Apache-2.0
// The guard's check of bytes, without a network.
#include "guard/datagram_check.hpp"

#include "guard/announcement.hpp"
#include "guard/lease_keeper.hpp"
#include "guard/returned_participants.hpp"
#include "wire/datagrams.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace vdrive::wire {
namespace {

using namespace std::chrono_literals;
using test::Body;
using test::data_to;
using test::Datagram;
using test::DatagramWriter;
using test::kSender;
using test::kUserReader;
using test::kUserWriter;

constexpr std::uint8_t kLittle = 1;
constexpr std::uint8_t kWithData = 5;
constexpr std::uint8_t kWithInlineQos = 3;

struct Case {
  const char* name;
  Refusal expected;
  std::function<Datagram()> make;
};

Datagram single(std::uint8_t kind, const Body& body, std::uint8_t flags = kLittle) {
  return DatagramWriter(kSender).add(kind, flags, body.bytes()).bytes();
}

Body heartbeat(std::int64_t first, std::int64_t last) {
  return test::heartbeat(kUserReader, kUserWriter, first, last);
}

Body acknack(std::int64_t base, std::uint32_t bits, std::size_t words) {
  return test::acknack(kUserReader, kUserWriter, base, bits, words);
}

Body nack_frag(std::uint32_t base, std::uint32_t bits, std::size_t words) {
  Body body;
  body.entity(kUserReader).entity(kUserWriter).sequence(1).u32(base).u32(bits);
  for (std::size_t word = 0; word < words; ++word) body.u32(0);
  return body.u32(1);
}

struct Fragment {
  std::uint32_t first = 1;
  std::uint32_t count = 1;
  std::uint32_t size = 1024;
  std::uint32_t sample = 3000;
  std::size_t content = 1024;
};

Datagram fragment(const Fragment& fragment, std::uint32_t reader = kUserReader) {
  Body body = data_to(reader, kUserWriter, 1, 28);
  body.u32(fragment.first).u16(fragment.count).u16(fragment.size).u32(fragment.sample);
  return single(0x16, body.raw(Datagram(fragment.content)));
}

Datagram user_data(std::int64_t sequence, std::uint32_t to_inline_qos = 16) {
  return single(
      0x15,
      data_to(kUserReader, kUserWriter, sequence, to_inline_qos).raw({0, 1, 0, 0, 1, 2, 3, 4}),
      kWithData);
}

Datagram discovery(const Datagram& list) {
  Body body = data_to(test::kPublicationsReader, test::kPublicationsWriter, 1);
  return single(0x15, body.raw({0, 3, 0, 0}).raw(list), kWithData);
}

/// @return the announcement of an endpoint with one parameter.
Datagram endpoint(std::uint16_t id, const Body& value) {
  return discovery(Body().parameter(id, value.bytes()).u32(1).bytes());
}

/// @param length of the expression as encoded, right or wrong
Datagram filtered_endpoint(std::uint32_t length, std::uint32_t parameters = 1) {
  Body body;
  for (const char name : {'t', 'u', 'c'}) {
    body.u32(2).raw({static_cast<std::uint8_t>(name), 0, 0, 0});
  }
  body.u32(length).raw({'x', ' ', '=', ' ', '%', '0', 0, 0}).u32(parameters);
  return endpoint(0x35, body.u32(2).raw({'1', 0}));
}

Datagram gap(std::int64_t start, std::int64_t base) {
  return single(0x08, test::gap(kUserReader, kUserWriter, start, base));
}

constexpr std::int64_t kTooLarge = (std::int64_t{1} << 40U) + 1;

std::vector<Case> cases() {
  const auto statistics = [](std::size_t size, std::size_t behind) {
    Datagram datagram = DatagramWriter(kSender).add(0x80, 0, Datagram(size)).bytes();
    datagram[22] = 0;  // the flag says big-endian
    datagram[23] = static_cast<std::uint8_t>(size);
    datagram.resize(datagram.size() + behind);
    return datagram;
  };
  return {
      {"Nothing", Refusal::header,
       [] {
         return Datagram{};
       }},
      {"HeaderAlone", Refusal::none,
       [] {
         return DatagramWriter(kSender).bytes();
       }},
      {"AnotherProtocol", Refusal::header,
       [] {
         return Datagram(100, 'x');
       }},
      {"LengthBeyondTheEnd", Refusal::length,
       [] {
         return DatagramWriter(kSender).add(0x07, 1, heartbeat(1, 1).bytes(), 32).bytes();
       }},
      {"HalfASubmessageHeader", Refusal::length,
       [] {
         Datagram datagram = gap(1, 2);
         datagram.resize(datagram.size() + 3);
         return datagram;
       }},
      {"UnalignedInTheMiddle", Refusal::length,
       [] {
         return DatagramWriter(kSender).add(0x01, 1, {0, 0}).add(0x01, 1, {0, 0}).bytes();
       }},
      {"LengthZeroExtendsToTheEnd", Refusal::none,
       [] {
         return DatagramWriter(kSender).add(0x07, 1, heartbeat(1, 1).bytes(), 0).bytes();
       }},
      {"AKindThatNobodyKnows", Refusal::submessage,
       [] {
         return single(0x22, Body().u32(0));
       }},
      {"AKindOfAnotherVendor", Refusal::none,
       [] {
         return single(0x81, Body().u32(0));
       }},
      {"StatisticsAtTheEnd", Refusal::none,
       [=] {
         return statistics(56, 0);
       }},
      {"StatisticsWithMoreBehind", Refusal::statistics,
       [=] {
         return statistics(56, 4);
       }},
      {"StatisticsTooShort", Refusal::statistics,
       [=] {
         return statistics(52, 0);
       }},
      {"Heartbeat", Refusal::none,
       [] {
         return single(0x07, heartbeat(5, 9));
       }},
      {"HeartbeatOfAnEmptyHistory", Refusal::none,
       [] {
         return single(0x07, heartbeat(1, 0));
       }},
      {"HeartbeatTurnedRound", Refusal::range,
       [] {
         return single(0x07, heartbeat(9, 5));
       }},
      {"HeartbeatFromZero", Refusal::sequence,
       [] {
         return single(0x07, heartbeat(0, 5));
       }},
      {"HeartbeatBeyondReason", Refusal::sequence,
       [] {
         return single(0x07, heartbeat(1, kTooLarge));
       }},
      {"HeartbeatTooShort", Refusal::length,
       [] {
         return single(0x07, Body().u32(0).u32(0));
       }},
      {"Acknack", Refusal::none,
       [] {
         return single(0x06, acknack(7, 33, 2));
       }},
      {"AcknackThatAsksForAHeartbeat", Refusal::none,
       [] {
         return single(0x06, acknack(0, 0, 0));
       }},
      {"AcknackOfANegativeNumber", Refusal::sequence,
       [] {
         return single(0x06, acknack(-1, 0, 0));
       }},
      {"AcknackWithTooManyBits", Refusal::set,
       [] {
         return single(0x06, acknack(7, 257, 9));
       }},
      {"AcknackWithoutItsWords", Refusal::length,
       [] {
         return single(0x06, acknack(7, 256, 2));
       }},
      {"NackFrag", Refusal::none,
       [] {
         return single(0x12, nack_frag(1, 256, 8));
       }},
      {"NackFragWithTooManyBits", Refusal::set,
       [] {
         return single(0x12, nack_frag(1, 257, 9));
       }},
      {"NackFragOfFragmentZero", Refusal::fragment,
       [] {
         return single(0x12, nack_frag(0, 32, 1));
       }},
      {"HeartbeatFragBeyondReason", Refusal::sequence,
       [] {
         return single(0x13, Body().u32(0).u32(0).sequence(kTooLarge).u32(1).u32(1));
       }},
      {"Gap", Refusal::none,
       [] {
         return gap(5, 9);
       }},
      {"GapWithASetAlone", Refusal::none,
       [] {
         return gap(5, 5);
       }},
      {"WidestGap", Refusal::none,
       [] {
         return gap(1, 1 + kWidestGap);
       }},
      {"GapWiderThanTheWidest", Refusal::range,
       [] {
         return gap(1, 2 + kWidestGap);
       }},
      {"GapTurnedRound", Refusal::range,
       [] {
         return gap(9, 5);
       }},
      {"GapFromZero", Refusal::sequence,
       [] {
         return gap(0, 5);
       }},
      {"GapToNegative", Refusal::sequence,
       [] {
         return gap(5, -5);
       }},
      {"Data", Refusal::none,
       [] {
         return user_data(1);
       }},
      {"DataWithoutANumber", Refusal::sequence,
       [] {
         return user_data(0);
       }},
      {"DataThatPointsIntoItsHead", Refusal::length,
       [] {
         return user_data(1, 12);
       }},
      {"DataThatPointsBehindItsEnd", Refusal::length,
       [] {
         return user_data(1, 64);
       }},
      {"DataOfTwoKinds", Refusal::data,
       [] {
         return single(0x15, data_to(kUserReader, kUserWriter, 1).raw(Datagram(16)), 0x0D);
       }},
      {"DataWithInlineQosThatDoesNotEnd", Refusal::length,
       [] {
         return single(0x15, data_to(kUserReader, kUserWriter, 1).u16(0x70).u16(64).u32(0),
                       kWithInlineQos);
       }},
      {"Fragment", Refusal::none,
       [] {
         return fragment({});
       }},
      {"LastFragment", Refusal::none,
       [] {
         return fragment({.first = 3, .content = 3000 - 2048});
       }},
      {"FragmentZero", Refusal::fragment,
       [] {
         return fragment({.first = 0});
       }},
      {"FragmentBehindTheLast", Refusal::fragment,
       [] {
         return fragment({.first = 4});
       }},
      {"FragmentThatIsTooShort", Refusal::fragment,
       [] {
         return fragment({.content = 1020});
       }},
      {"FragmentOfNothing", Refusal::fragment,
       [] {
         return fragment({.size = 0});
       }},
      {"FragmentOfAGigabyte", Refusal::fragment,
       [] {
         return fragment({.sample = 1U << 30U});
       }},
      {"LastFragmentOfOneByte", Refusal::none,
       [] {
         return fragment({.first = 3, .sample = 2049, .content = 1});
       }},
      {"LastFragmentWhoseNumberLiesBehindTheSample", Refusal::fragment,
       [] {
         return fragment({.size = 799, .sample = 800});
       }},
      {"AnnouncementInPieces", Refusal::announcement,
       [] {
         return fragment({}, test::kParticipantsReader);
       }},
      {"Endpoint", Refusal::none,
       [] {
         return discovery(Body().parameter(5, {2, 0, 0, 0, 'a', 0}).u32(1).bytes());
       }},
      {"EndpointWithoutASentinel", Refusal::parameters,
       [] {
         return discovery(Body().parameter(5, {2, 0, 0, 0, 'a', 0}).bytes());
       }},
      {"EndpointWithATextTooLong", Refusal::parameters,
       [] {
         return discovery(Body().parameter(5, {99, 0, 0, 0, 'a', 0}).u32(1).bytes());
       }},
      {"EndpointInPartitions", Refusal::none,
       [] {
         return endpoint(0x29, Body().u32(2).u32(2).raw({'a', 0, 0, 0}).u32(3).raw({'b', 'c', 0}));
       }},
      {"EndpointInAPartitionWhoseLengthWraps", Refusal::parameters,
       [] {
         return endpoint(0x29, Body().u32(0xFFFFFFFF).u32(0xFFFFFFFC));
       }},
      {"EndpointInMorePartitionsThanItHas", Refusal::parameters,
       [] {
         return endpoint(0x29, Body().u32(2).u32(2).raw({'a', 0, 0, 0}));
       }},
      {"EndpointWithRepresentations", Refusal::none,
       [] {
         return endpoint(0x73, Body().u32(3).u16(0).u16(1).u16(2));
       }},
      {"EndpointWith4GigaRepresentations", Refusal::parameters,
       [] {
         return endpoint(0x73, Body().u32(0xFFFFFFFF).u32(0));
       }},
      {"EndpointThatSharesDataOfADomain", Refusal::none,
       [] {
         return endpoint(0x8006, Body().u32(1).u32(1).u32(2));
       }},
      {"EndpointThatAcknowledgesNothingToAnotherVendor", Refusal::none,
       [] {
         return endpoint(0x8006, Body().u32(1));
       }},
      {"EndpointThatSharesDataOf4GigaDomains", Refusal::parameters,
       [] {
         return endpoint(0x8006, Body().u32(0xFFFFFFFF).u32(1).u32(2));
       }},
      {"EndpointWithAFilter", Refusal::none,
       [] {
         return filtered_endpoint(7);
       }},
      {"EndpointWithAFilterWhoseLengthWraps", Refusal::parameters,
       [] {
         return filtered_endpoint(0xFFFFFFFF);
       }},
      {"EndpointWithAFilterOfMoreParametersThanItHas", Refusal::parameters,
       [] {
         return filtered_endpoint(7, 2);
       }},
      {"EndpointThatIsNoList", Refusal::parameters,
       [] {
         return single(0x15,
                       data_to(test::kPublicationsReader, test::kPublicationsWriter, 1)
                           .raw({0, 1, 0, 0, 1, 0, 0, 0}),
                       kWithData);
       }},
      {"Announcement", Refusal::none,
       [] {
         return single(0x15, test::announcement(kSender, "some name", 20), kWithData);
       }},
      {"EndOfAParticipant", Refusal::none,
       [] {
         return end_datagram(kSender);
       }},
  };
}

class CheckedDatagram : public testing::TestWithParam<Case> {};

TEST_P(CheckedDatagram, IsAcceptedOrRefusedByItsBytes) {
  const Datagram datagram = GetParam().make();
  EXPECT_EQ(describe(check_datagram(datagram).refusal), describe(GetParam().expected));
}

INSTANTIATE_TEST_SUITE_P(Kinds, CheckedDatagram, testing::ValuesIn(cases()), [](const auto& row) {
  return std::string(row.param.name);
});

TEST(DatagramCheck, SurvivesEveryTruncation) {
  for (const auto& row : cases()) {
    const Datagram whole = row.make();
    for (std::size_t size = 0; size < whole.size(); ++size) {
      // On the heap and exactly this long, so that a sanitizer detects any access beyond it.
      const Datagram part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      static_cast<void>(check_datagram(part));
    }
  }
}

TEST(DatagramCheck, RemovesTheStatisticsOfFastDds) {
  Datagram datagram = user_data(1);
  const std::size_t without = datagram.size();
  const Datagram statistics = DatagramWriter(kSender).add(0x80, 1, Datagram(56)).bytes();
  datagram.insert(datagram.end(), statistics.begin() + 20, statistics.end());
  const DatagramReport report = check_datagram(datagram);
  EXPECT_EQ(report.refusal, Refusal::none);
  EXPECT_EQ(report.length, without);
}

/// @return the announcement in a datagram with one submessage.
std::optional<Announcement> announcement_in(const Datagram& datagram) {
  Submessages submessages(datagram);
  Submessage submessage;
  if (!submessages.next(submessage)) return std::nullopt;
  return read_announcement(submessage, parse_data(submessage, 16));
}

/// @return the parameter list in a datagram with one DATA submessage.
std::span<std::uint8_t> list_of(Datagram& datagram) {
  Submessages submessages(datagram);
  Submessage submessage;
  EXPECT_TRUE(submessages.next(submessage));
  return list_in(datagram, submessage, parse_data(submessage, 16));
}

TEST(Announcement, NamesParticipantLeaseAndKindOfProgram) {
  const auto read_one = [](const char* name) {
    return announcement_in(single(0x15, test::announcement(kSender, name, 20), kWithData));
  };
  ASSERT_TRUE(read_one("vdrived 1"));
  EXPECT_EQ(read_one("vdrived 1")->participant, kSender);
  EXPECT_EQ(read_one("vdrived 1")->lease, 20s);
  EXPECT_EQ(read_one("vdrived 1")->announcer, Announcer::vdrive);
  EXPECT_EQ(read_one("vdrive client")->announcer, Announcer::vdrive_visitor);
  EXPECT_EQ(read_one("vdrive probe")->announcer, Announcer::vdrive_visitor);
  EXPECT_EQ(read_one("talker")->announcer, Announcer::foreign);
  EXPECT_EQ(read_one("")->announcer, Announcer::foreign);
}

TEST(Announcement, IsPassedToTheLibraryWithARaisedLease) {
  Datagram datagram = single(0x15, test::announcement(kSender, "talker", 2), kWithData);
  raise_leases(list_of(datagram), true);
  ASSERT_TRUE(announcement_in(datagram));
  EXPECT_EQ(announcement_in(datagram)->lease, kLeaseForTheLibrary);
  EXPECT_EQ(check_datagram(datagram).refusal, Refusal::none);
}

// A list that a program sends as its own data has not been checked, so it may end anywhere.
TEST(Announcement, WithATruncatedListIsUnchanged) {
  for (const std::size_t length : {4U, 6U, 10U}) {
    Body body = data_to(0x07010000, 0x02010000, 1);  // a reader and a writer of a program
    body.raw({0, 3, 0, 0}).raw({2, 0, 4, 0, 1, 2, 3, 4, 0x75, 0});  // a lease of 4 bytes, a type id
    Datagram datagram = single(0x15, body, kWithData);
    Datagram changed = datagram;
    const auto list = list_of(changed).first(length);
    raise_leases(list, true);
    hide_types(list, true);
    EXPECT_EQ(changed, datagram) << length;
  }
}

TEST(Announcement, OfADepartureNamesTheParticipant) {
  const auto leaving = announcement_in(end_datagram(kSender));
  ASSERT_TRUE(leaving);
  EXPECT_TRUE(leaving->gone);
  EXPECT_EQ(leaving->participant, kSender);
}

// Cyclone DDS sends the key in the content, where Fast DDS does not look for it.
TEST(Announcement, OfADepartureCanHaveItsKeyInTheContent) {
  Body body = data_to(test::kParticipantsReader, test::kParticipantsWriter, 2);
  body.parameter(0x71, {0, 0, 0, 3}).u32(1);
  body.raw({0, 3, 0, 0}).parameter(0x50, test::guid_of(kSender)).u32(1);
  const Datagram datagram = single(0x15, body, 0x0B);
  EXPECT_EQ(check_datagram(datagram).refusal, Refusal::none);
  const auto leaving = announcement_in(datagram);
  ASSERT_TRUE(leaving);
  EXPECT_EQ(leaving->participant, kSender);
  EXPECT_FALSE(leaving->library_knows_key);
}

class Keeper : public testing::Test {
 protected:
  using Lease = LeaseKeeper<int>;
  Lease keeper_;
  Lease::Clock::time_point now_{1h};
};

TEST_F(Keeper, ReportsAParticipantThatIsSilentLongerThanItsLease) {
  ASSERT_TRUE(keeper_.announced(kSender, 2s, 7, now_));
  EXPECT_TRUE(keeper_.take_silent(now_ + 2s).empty());
  const auto silent = keeper_.take_silent(now_ + 2001ms);
  ASSERT_EQ(silent.size(), 1U);
  EXPECT_EQ(silent.front().participant, kSender);
  EXPECT_EQ(silent.front().channel, 7);
  EXPECT_TRUE(keeper_.take_silent(now_ + 1h).empty()) << "reported twice";
}

TEST_F(Keeper, AcceptsAnyDatagramAsASignOfLife) {
  ASSERT_TRUE(keeper_.announced(kSender, 2s, 7, now_));
  keeper_.note_datagram(kSender, now_ + 1500ms);
  EXPECT_TRUE(keeper_.take_silent(now_ + 3s).empty());
  EXPECT_EQ(keeper_.take_silent(now_ + 4s).size(), 1U);
}

TEST_F(Keeper, ForgetsDepartedParticipantsAndClosedChannels) {
  ASSERT_TRUE(keeper_.announced(kSender, 2s, 7, now_));
  keeper_.left(kSender);
  ASSERT_TRUE(keeper_.announced({1}, 2s, 8, now_));
  keeper_.closed(8);
  EXPECT_TRUE(keeper_.take_silent(now_ + 1h).empty());
}

TEST_F(Keeper, NeverReportsAnInfiniteLease) {
  ASSERT_TRUE(keeper_.announced(kSender, Lease::Clock::duration::max(), 7, now_));
  EXPECT_TRUE(keeper_.take_silent(now_ + 10'000h).empty());
}

TEST_F(Keeper, KeepsABoundedNumberOfParticipants) {
  for (std::size_t number = 0; number < Lease::kMostParticipants; ++number) {
    const GuidPrefix prefix{static_cast<std::uint8_t>(number),
                            static_cast<std::uint8_t>(number >> 8U)};
    ASSERT_TRUE(keeper_.announced(prefix, 2s, 7, now_));
  }
  EXPECT_FALSE(keeper_.announced({1, 2, 3}, 2s, 7, now_));
  EXPECT_TRUE(keeper_.announced({1, 2}, 2s, 7, now_)) << "it is known";
}

class Returned : public testing::Test {
 protected:
  static constexpr EntityId kWriter = kPublicationsWriter;

  ReturnedParticipants returned_;
  ReturnedParticipants::Clock::time_point now_{1h};
};

TEST_F(Returned, ParticipantsWaitWithTheHeartbeatsOfAWriterUntilItWasAskedForEverything) {
  returned_.removed(kSender);
  EXPECT_TRUE(returned_.empty());
  returned_.announced(kSender, now_);
  EXPECT_TRUE(returned_.holds_back(kSender, kWriter, now_));
  returned_.initial_acknack_sent(kSender, kWriter);
  EXPECT_FALSE(returned_.holds_back(kSender, kWriter, now_));
  EXPECT_TRUE(returned_.holds_back(kSender, kSubscriptionsWriter, now_ + 1'999ms));
  EXPECT_FALSE(returned_.holds_back(kSender, kSubscriptionsWriter, now_ + 2s));
  returned_.forget_old(now_ + 2s);
  EXPECT_TRUE(returned_.empty());
}

TEST_F(Returned, AreNeitherNewParticipantsNorThoseThatLeftByThemselves) {
  returned_.announced(kSender, now_);
  EXPECT_FALSE(returned_.holds_back(kSender, kWriter, now_)) << "it is new";
  returned_.removed(kSender);
  returned_.left(kSender);
  returned_.announced(kSender, now_);
  EXPECT_FALSE(returned_.holds_back(kSender, kWriter, now_)) << "it left";
}

TEST_F(Returned, AnnounceThemselvesAgainAndAgainAndWaitOnce) {
  returned_.removed(kSender);
  returned_.announced(kSender, now_);
  returned_.announced(kSender, now_ + 1s);
  EXPECT_FALSE(returned_.holds_back(kSender, kWriter, now_ + 2s)) << "since the first one";
}

TEST_F(Returned, AreRememberedInABoundedNumber) {
  for (std::size_t number = 0; number <= ReturnedParticipants::kMostRemoved; ++number) {
    returned_.removed({static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8U)});
  }
  std::size_t remembered = 0;
  for (std::size_t number = 0; number <= ReturnedParticipants::kMostRemoved; ++number) {
    const GuidPrefix prefix{static_cast<std::uint8_t>(number),
                            static_cast<std::uint8_t>(number >> 8U)};
    returned_.announced(prefix, now_);
    remembered += returned_.holds_back(prefix, kWriter, now_) ? 1 : 0;
  }
  EXPECT_EQ(remembered, ReturnedParticipants::kMostRemoved);
}

}  // namespace
}  // namespace vdrive::wire

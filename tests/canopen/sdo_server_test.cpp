// SPDX-License-Identifier: Apache-2.0
// Unit tests of the SDO server (CiA 301, 7.2.4.3), byte by byte. Node 1: requests 601h, responses
// 581h.
#include "node/sdo_server.hpp"

#include "canopen/served_sdo.hpp"
#include "support/random_cases.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <rapidcheck.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint16_t kNumbers = 0x2000;       // sub-index = size [bytes]
constexpr std::uint16_t kDriveNumbers = 0x2001;  // likewise, answered later
constexpr std::uint16_t kTexts = 0x2002;         // sub-index = length

/// Objects whose sub-index is their size. Numbers read as 11h, 22h, 33h, 44h; texts as "abcdef...".
class FakeObjects final : public SdoObjects {
 public:
  struct Download {
    ObjectAddress object;
    std::vector<std::uint8_t> data;
  };

  [[nodiscard]] SdoTarget check_download(ObjectAddress object) const override {
    if (!has_size(object)) return {.abort = AbortCode::subindex_does_not_exist};
    switch (object.index) {
      case kNumbers:
      case kDriveNumbers:
        return {.size = object.subindex};
      case kTexts:
        return {.abort = AbortCode::write_of_read_only_object};
      default:
        return {.abort = AbortCode::object_does_not_exist};
    }
  }

  std::optional<SdoAnswer> begin_upload(ObjectAddress object) override {
    if (!has_size(object)) return SdoAnswer{.abort = AbortCode::subindex_does_not_exist};
    switch (object.index) {
      case kNumbers:
        return SdoAnswer{.bytes = number(object.subindex)};
      case kDriveNumbers:
        ++begun;
        return std::nullopt;
      case kTexts:
        return SdoAnswer{.bytes = text(object.subindex), .is_text = true};
      default:
        return SdoAnswer{.abort = AbortCode::object_does_not_exist};
    }
  }

  std::optional<SdoAnswer> begin_download(ObjectAddress object, std::span<const std::uint8_t> data,
                                          DriveTime) override {
    downloads.push_back({object, {data.begin(), data.end()}});
    if (object.index != kDriveNumbers) return SdoAnswer{.abort = refusal};
    ++begun;
    return std::nullopt;
  }

  static bool has_size(ObjectAddress object) {
    const bool is_number = object.index == kNumbers || object.index == kDriveNumbers;
    return !is_number || (object.subindex >= 1 && object.subindex <= 4);
  }

  static std::string number(std::size_t size) {
    return std::string("\x11\x22\x33\x44").substr(0, size);
  }

  static std::string text(std::size_t size) {
    return std::string("abcdefghijklmnopqrstuvwxyz").substr(0, size);
  }

  std::vector<Download> downloads;
  AbortCode refusal = AbortCode::none;  ///< abort code of downloads that are answered immediately
  int begun = 0;                        ///< accesses waiting for SdoServer::finish()
};

using SdoServerUnderTest = ServedSdo<FakeObjects>;

struct SizeRow {
  const char* name;
  const char* upload;
  const char* response;  // command: 43h plus four times the number of unused bytes
  const char* download;
  std::vector<std::uint8_t> data;
};

std::ostream& operator<<(std::ostream& stream, const SizeRow& row) {
  return stream << row.name;
}

class SdoNumber : public testing::TestWithParam<SizeRow> {
 protected:
  SdoServerUnderTest sdo;
};

TEST_P(SdoNumber, IsUploadedExpeditedWithItsSize) {
  EXPECT_THAT(sdo.request(GetParam().upload), ElementsAre(GetParam().response));
}

TEST_P(SdoNumber, IsDownloadedExpedited) {
  const std::string multiplexer = std::string(GetParam().download).substr(2, 6);
  EXPECT_THAT(sdo.request(GetParam().download),
              ElementsAre("581#60" + multiplexer + std::string(8, '0')));
  ASSERT_EQ(sdo.objects.downloads.size(), 1U);
  EXPECT_EQ(sdo.objects.downloads[0].data, GetParam().data);
  EXPECT_EQ(sdo.objects.downloads[0].object.index, kNumbers);
}

INSTANTIATE_TEST_SUITE_P(
    OfSize, SdoNumber,
    testing::Values(
        SizeRow{"1", "40002001", "581#4F00200111000000", "2F002001A1", {0xA1}},
        SizeRow{"2", "40002002", "581#4B00200211220000", "2B002002A1A2", {0xA1, 0xA2}},
        SizeRow{"3", "40002003", "581#4700200311223300", "27002003A1A2A3", {0xA1, 0xA2, 0xA3}},
        SizeRow{
            "4", "40002004", "581#4300200411223344", "23002004A1A2A3A4", {0xA1, 0xA2, 0xA3, 0xA4}}),
    [](const auto& row) {
      return "Bytes" + std::string(row.param.name);
    });

TEST(SdoServer, AnswersAnUnknownObjectWithAbort06020000) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("40 00 30 05"), ElementsAre("581#8000300500000206"));
  EXPECT_THAT(sdo.request("2F 00 30 05 01"), ElementsAre("581#8000300500000206"));
  EXPECT_EQ(sdo.server.counters().aborts, 2U);
}

TEST(SdoServer, AnswersADownloadToAReadOnlyObjectWithAbort06010002) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("2F 02 20 04 41"), ElementsAre("581#8002200402000106"));
  EXPECT_THAT(sdo.request("21 02 20 04 04"), ElementsAre("581#8002200402000106")) << "segmented";
}

TEST(SdoServer, PassesOnTheRefusalOfAValue) {
  SdoServerUnderTest sdo;
  sdo.objects.refusal = AbortCode::value_too_high;
  EXPECT_THAT(sdo.request("2F 00 20 01 FF"), ElementsAre("581#8000200131000906"));
}

// 41h: size indicated, not expedited. Then 7 bytes per segment. The last segment has bit 0 set, and
// its number of unused bytes in bits 1 to 3: "hijkl" leaves 2, so 10h | 2 << 1 | 1 = 15h.
TEST(SdoServer, UploadsATextBySegmentsWithAlternatingToggle) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("40 02 20 0C"), ElementsAre("581#4102200C0C000000"));
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#0061626364656667"));
  EXPECT_THAT(sdo.request("70"), ElementsAre("581#1568696A6B6C0000"));
}

TEST(SdoServer, UploadsATextOfSevenBytesInOneSegment) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("40 02 20 07"), ElementsAre("581#4102200707000000"));
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#0161626364656667"));
}

TEST(SdoServer, UploadsATextOfFourteenBytesInTwoSegments) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("40 02 20 0E"), ElementsAre("581#4102200E0E000000"));
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#0061626364656667"));
  EXPECT_THAT(sdo.request("70"), ElementsAre("581#1168696A6B6C6D6E"));
}

TEST(SdoServer, UploadsAShortTextBySegmentsToo) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("40 02 20 01"), ElementsAre("581#4102200101000000"));
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#0D61000000000000")) << "6 << 1 | 1";
}

TEST(SdoServer, UploadsAnEmptyTextInOneEmptySegment) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("40 02 20 00"), ElementsAre("581#4102200000000000"));
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#0F00000000000000")) << "7 << 1 | 1";
}

TEST(SdoServer, EndsAnUploadWithItsLastSegment) {
  SdoServerUnderTest sdo;
  sdo.request("40 02 20 01");
  sdo.request("60");
  EXPECT_THAT(sdo.request("70"), ElementsAre("581#8000000001000405"));
}

TEST(SdoServer, TakesAnExpeditedDownloadWithoutSizeAsOneOfTheSizeOfTheObject) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("22 00 20 02 A1 A2 A3 A4"), ElementsAre("581#6000200200000000"));
  ASSERT_EQ(sdo.objects.downloads.size(), 1U);
  EXPECT_THAT(sdo.objects.downloads[0].data, ElementsAre(0xA1, 0xA2));
}

TEST(SdoServer, RefusesAnExpeditedDownloadThatIsTooLongWith06070012) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("23 00 20 02 A1 A2 A3 A4"), ElementsAre("581#8000200212000706"));
  EXPECT_THAT(sdo.objects.downloads, IsEmpty());
}

TEST(SdoServer, RefusesAnExpeditedDownloadThatIsTooShortWith06070013) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("2B 00 20 04 A1 A2"), ElementsAre("581#8000200413000706"));
  EXPECT_THAT(sdo.objects.downloads, IsEmpty());
}

// 7 - 4 bytes unused: 3 << 1 | 1 = 07h.
TEST(SdoServer, TakesADownloadOfOneSegment) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("21 00 20 04 04"), ElementsAre("581#6000200400000000"));
  EXPECT_THAT(sdo.request("07 A1 A2 A3 A4"), ElementsAre("581#2000000000000000"));
  ASSERT_EQ(sdo.objects.downloads.size(), 1U);
  EXPECT_THAT(sdo.objects.downloads[0].data, ElementsAre(0xA1, 0xA2, 0xA3, 0xA4));
  EXPECT_EQ(sdo.objects.downloads[0].object, (ObjectAddress{kNumbers, 4}));
}

// Segments of 1, 2 and 1 bytes: 6 << 1 = 0Ch; 10h | 5 << 1 = 1Ah; 6 << 1 | 1 = 0Dh.
TEST(SdoServer, JoinsTheSegmentsOfADownload) {
  SdoServerUnderTest sdo;
  sdo.request("21 00 20 04 04");
  EXPECT_THAT(sdo.request("0C A1"), ElementsAre("581#2000000000000000"));
  EXPECT_THAT(sdo.request("1A A2 A3"), ElementsAre("581#3000000000000000"));
  EXPECT_THAT(sdo.objects.downloads, IsEmpty());
  EXPECT_THAT(sdo.request("0D A4"), ElementsAre("581#2000000000000000"));
  ASSERT_EQ(sdo.objects.downloads.size(), 1U);
  EXPECT_THAT(sdo.objects.downloads[0].data, ElementsAre(0xA1, 0xA2, 0xA3, 0xA4));
}

TEST(SdoServer, TakesASegmentedDownloadWithoutIndicatedSize) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("20 00 20 01"), ElementsAre("581#6000200100000000"));
  EXPECT_THAT(sdo.request("0D A1"), ElementsAre("581#2000000000000000"));
  EXPECT_EQ(sdo.objects.downloads.size(), 1U);
}

TEST(SdoServer, RefusesAnIndicatedSizeThatIsNotThatOfTheObject) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("21 00 20 04 05"), ElementsAre("581#8000200412000706"));
  EXPECT_THAT(sdo.request("21 00 20 04 03"), ElementsAre("581#8000200413000706"));
  EXPECT_THAT(sdo.request("21 00 20 04 04 00 00 01"), ElementsAre("581#8000200412000706"))
      << "01000004h bytes";
}

TEST(SdoServer, RefusesMoreDataThanTheObjectHasWithTheSegmentThatBringsThem) {
  SdoServerUnderTest sdo;
  sdo.request("20 00 20 02");
  EXPECT_THAT(sdo.request("08 A1 A2 A3"), ElementsAre("581#8000200212000706"));
  EXPECT_THAT(sdo.request("1D A4"), ElementsAre("581#8000000001000405")) << "it has ended";
  EXPECT_THAT(sdo.objects.downloads, IsEmpty());
}

TEST(SdoServer, RefusesALastSegmentThatLeavesBytesOpen) {
  SdoServerUnderTest sdo;
  sdo.request("21 00 20 04 04");
  EXPECT_THAT(sdo.request("09 A1 A2 A3"), ElementsAre("581#8000200413000706"));
  EXPECT_THAT(sdo.objects.downloads, IsEmpty());
}

TEST(SdoServer, AbortsADownloadWhoseToggleDoesNotAlternate) {
  SdoServerUnderTest sdo;
  sdo.request("21 00 20 04 04");
  sdo.request("0C A1");
  EXPECT_THAT(sdo.request("0C A2"), ElementsAre("581#8000200400000305"));
  EXPECT_THAT(sdo.request("1C A2"), ElementsAre("581#8000000001000405")) << "it has ended";
}

TEST(SdoServer, AbortsAnUploadThatBeginsWithTheWrongToggle) {
  SdoServerUnderTest sdo;
  sdo.request("40 02 20 0C");
  EXPECT_THAT(sdo.request("70"), ElementsAre("581#8002200C00000305"));
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#8000000001000405")) << "it has ended";
}

TEST(SdoServer, AnswersASegmentOfNoTransferWithAbort05040001) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("00 A1"), ElementsAre("581#8000000001000405"));
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#8000000001000405"));
}

TEST(SdoServer, AnswersASegmentOfTheOtherDirectionWithAbort05040001) {
  SdoServerUnderTest sdo;
  sdo.request("21 00 20 04 04");
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#8000200401000405"));
  sdo.request("40 02 20 0C");
  EXPECT_THAT(sdo.request("00 A1"), ElementsAre("581#8002200C01000405"));
}

struct UnknownRow {
  const char* name;
  const char* request;
  const char* answer;
};

std::ostream& operator<<(std::ostream& stream, const UnknownRow& row) {
  return stream << row.name;
}

class UnknownCommand : public testing::TestWithParam<UnknownRow> {};

TEST_P(UnknownCommand, IsAnsweredWithAbort05040001) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request(GetParam().request), ElementsAre(GetParam().answer));
  EXPECT_EQ(sdo.server.counters().aborts, 1U);
}

// Commands of a block transfer that was not begun. The answer names no object, because only an
// initiate request contains one.
INSTANTIATE_TEST_SUITE_P(
    Each, UnknownCommand,
    testing::Values(UnknownRow{"BlockUploadStart", "A3", "581#8000000001000405"},
                    UnknownRow{"BlockUploadEnd", "A1", "581#8000000001000405"},
                    UnknownRow{"BlockUploadResponse", "A2 7F 7F 7F", "581#8000000001000405"},
                    UnknownRow{"BlockDownloadEnd", "C1 12 34 56", "581#8000000001000405"},
                    UnknownRow{"Specifier7", "E0 00 20 04", "581#8000000001000405"}),
    [](const auto& row) {
      return std::string(row.param.name);
    });

TEST(SdoServer, EndsATransferWithAnUnknownCommandAndNamesItsObject) {
  SdoServerUnderTest sdo;
  sdo.request("40 02 20 0C");
  EXPECT_THAT(sdo.request("E0"), ElementsAre("581#8002200C01000405"));
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#8000000001000405"));
}

TEST(SdoServer, LeavesAnAbortOfTheClientUnanswered) {
  SdoServerUnderTest sdo;
  sdo.request("40 02 20 0C");
  EXPECT_THAT(sdo.request("80 02 20 0C 00 00 00 08"), IsEmpty());
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#8000000001000405")) << "the transfer has ended";
}

TEST(SdoServer, StartsANewTransferWithAnInitiateInTheMiddleOfOne) {
  SdoServerUnderTest sdo;
  sdo.request("40 02 20 0E");
  sdo.request("60");
  EXPECT_THAT(sdo.request("40 02 20 08"), ElementsAre("581#4102200808000000"));
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#0061626364656667")) << "the toggle begins anew";
  EXPECT_THAT(sdo.request("70"), ElementsAre("581#1D68000000000000"));
}

TEST(SdoServer, EndsASegmentedTransferWithAnExpeditedOne) {
  SdoServerUnderTest sdo;
  sdo.request("21 00 20 04 04");
  EXPECT_THAT(sdo.request("40 00 20 01"), ElementsAre("581#4F00200111000000"));
  EXPECT_THAT(sdo.request("07 A1 A2 A3 A4"), ElementsAre("581#8000000001000405"));
}

TEST(SdoServer, AbortsATransferThatTheClientDoesNotContinueForASecond) {
  SdoServerUnderTest sdo;
  sdo.now = 5s;
  sdo.request("40 02 20 0C");
  EXPECT_EQ(sdo.server.next_due(), DriveTime(6s));
  EXPECT_THAT(sdo.advance(5'999'999us), IsEmpty());
  EXPECT_THAT(sdo.advance(6s), ElementsAre("581#8002200C00000405"));
  EXPECT_EQ(sdo.server.counters().time_outs, 1U);
  EXPECT_EQ(sdo.server.counters().aborts, 1U);
  EXPECT_EQ(sdo.server.next_due(), std::nullopt);
  EXPECT_THAT(sdo.request("60"), ElementsAre("581#8000000001000405"));
}

TEST(SdoServer, GivesASecondForEachSegment) {
  SdoServerUnderTest sdo;
  sdo.request("21 00 20 04 04");
  sdo.now = 900ms;
  sdo.request("0C A1");
  EXPECT_THAT(sdo.advance(1s), IsEmpty());
  EXPECT_EQ(sdo.server.next_due(), DriveTime(1'900ms));
  EXPECT_THAT(sdo.advance(1'900ms), ElementsAre("581#8000200400000405"));
}

TEST(SdoServer, WaitsForNoClientOutsideOfATransfer) {
  SdoServerUnderTest sdo;
  EXPECT_EQ(sdo.server.next_due(), std::nullopt);
  sdo.request("40 00 20 01");
  EXPECT_EQ(sdo.server.next_due(), std::nullopt) << "expedited";
  sdo.request("40 02 20 01");
  sdo.request("60");
  EXPECT_EQ(sdo.server.next_due(), std::nullopt) << "the last segment was sent";
  EXPECT_THAT(sdo.advance(10s), IsEmpty());
}

TEST(SdoServer, AnswersWhenTheDriveHasAnswered) {
  SdoServerUnderTest sdo;
  EXPECT_THAT(sdo.request("40 01 20 02"), IsEmpty());
  EXPECT_THAT(sdo.finish({.bytes = "\x50\x02"}), ElementsAre("581#4B01200250020000"));
  EXPECT_THAT(sdo.request("2B 01 20 02 0F"), IsEmpty());
  EXPECT_THAT(sdo.finish({}), ElementsAre("581#6001200200000000"));
}

TEST(SdoServer, PassesOnTheRefusalOfTheDrive) {
  SdoServerUnderTest sdo;
  sdo.request("2B 01 20 02 0F");
  EXPECT_THAT(sdo.finish({.abort = AbortCode::refused_local_control}),
              ElementsAre("581#8001200221000008"));
}

TEST(SdoServer, AnswersTheLastSegmentWhenTheDriveHasAnswered) {
  SdoServerUnderTest sdo;
  sdo.request("21 01 20 01 01");
  EXPECT_THAT(sdo.request("0D A1"), IsEmpty());
  EXPECT_THAT(sdo.finish({}), ElementsAre("581#2000000000000000"));
  sdo.request("21 01 20 01 01");
  sdo.request("0D A1");
  EXPECT_THAT(sdo.finish({.abort = AbortCode::value_too_low}), ElementsAre("581#8001200132000906"))
      << "an abort names the object";
}

TEST(SdoServer, HasNoTimeOutWhileTheDriveIsAsked) {
  SdoServerUnderTest sdo;
  sdo.request("40 01 20 02");
  EXPECT_EQ(sdo.server.next_due(), std::nullopt);
  EXPECT_THAT(sdo.advance(1h), IsEmpty());
}

TEST(SdoServer, AnswersRequestsThatComeDuringAnAccessInTheirOrder) {
  SdoServerUnderTest sdo;
  sdo.request("40 01 20 01");
  EXPECT_THAT(sdo.request("40 00 20 01"), IsEmpty());
  EXPECT_THAT(sdo.request("40 01 20 02"), IsEmpty());
  EXPECT_THAT(sdo.request("60"), IsEmpty());
  EXPECT_EQ(sdo.objects.begun, 1) << "one access at a time";
  EXPECT_THAT(sdo.finish({.bytes = "\x01"}),
              ElementsAre("581#4F01200101000000", "581#4F00200111000000"));
  EXPECT_EQ(sdo.objects.begun, 2);
  EXPECT_THAT(sdo.finish({.bytes = "\x02\x03"}),
              ElementsAre("581#4B01200202030000", "581#8000000001000405"));
}

TEST(SdoServer, RefusesRequestsBeyondThoseThatMayWaitWith05040005) {
  SdoServerUnderTest sdo;
  sdo.request("40 01 20 01");
  for (std::size_t i = 0; i < SdoServer::kMostWaiting; ++i) {
    EXPECT_THAT(sdo.request("40 00 20 01"), IsEmpty());
  }
  EXPECT_THAT(sdo.request("40 00 20 02"), ElementsAre("581#8000200205000405"));
  EXPECT_EQ(sdo.finish({.bytes = "\x01"}).size(), SdoServer::kMostWaiting + 1);
}

TEST(SdoServer, GivesNoAnswerToAClientThatAbortedDuringAnAccess) {
  SdoServerUnderTest sdo;
  sdo.request("40 01 20 01");
  sdo.request("40 00 20 01");
  EXPECT_THAT(sdo.request("80 01 20 01"), IsEmpty());
  EXPECT_THAT(sdo.request("40 00 20 02"), IsEmpty()) << "the access has not ended";
  EXPECT_THAT(sdo.finish({.bytes = "\x01"}), ElementsAre("581#4B00200211220000"))
      << "of what came behind the abort";
}

TEST(SdoServer, AnswersNothingAnyMoreOnceItIsStopped) {
  SdoServerUnderTest sdo;
  sdo.request("40 02 20 0C");
  sdo.server.stop();
  EXPECT_EQ(sdo.server.next_due(), std::nullopt);
  sdo.request("40 01 20 01");
  sdo.request("40 00 20 01");
  sdo.server.stop();
  EXPECT_THAT(sdo.finish({.bytes = "\x01"}), IsEmpty());
  EXPECT_THAT(sdo.request("40 00 20 01"), ElementsAre("581#4F00200111000000"));
}

TEST(SdoServer, ForgetsTheAccessUnderWayWithAReset) {
  SdoServerUnderTest sdo;
  sdo.request("40 01 20 01");
  sdo.server.reset();
  EXPECT_THAT(sdo.request("40 00 20 01"), ElementsAre("581#4F00200111000000"));
  EXPECT_THAT(sdo.finish({.bytes = "\x01"}), IsEmpty());
}

TEST(SdoServer, AnswersEveryFirstByteButAnAbortOnce) {
  for (std::uint32_t first = 0; first <= 0xFF; ++first) {
    SdoServerUnderTest sdo;
    const bool is_abort = first >> 5U == 4;
    EXPECT_EQ(sdo.request(hex_digits(first, 2) + "002001").size(), is_abort ? 0U : 1U) << first;
    SdoServerUnderTest transfer;
    transfer.request("40 02 20 1A");
    EXPECT_EQ(transfer.request(hex_digits(first, 2) + "002001").size(), is_abort ? 0U : 1U)
        << first << " in an upload";
  }
}

/// Either a request, usually for an existing object and never an abort or part of a block transfer;
/// or the drive's answer to the access in progress, if there is one.
struct SdoEvent {
  bool is_answer = false;
  std::array<std::uint8_t, kMostData> request{};
};

std::ostream& operator<<(std::ostream& stream, const SdoEvent& event) {
  Frame frame{.id = 0x601, .size = kMostData, .data = event.request};
  return event.is_answer ? stream << "answer" : stream << frame;
}

rc::Gen<std::array<std::uint8_t, kMostData>> any_sdo_request() {
  using Bytes = std::array<std::uint8_t, kMostData>;
  return rc::gen::map(
      rc::gen::tuple(rc::gen::arbitrary<Bytes>(), rc::gen::inRange<std::uint16_t>(0x2000, 0x2004),
                     rc::gen::inRange<std::uint8_t>(1, 5), rc::gen::arbitrary<bool>()),
      [](const auto& parts) {
        auto [bytes, index, subindex, is_segment] = parts;
        // No abort, and no block transfer: a block has one answer, which may be several frames.
        if (bytes[0] >> 5U >= 4 && bytes[0] >> 5U <= 6) bytes[0] = 0x40;
        if (is_segment) return bytes;
        bytes[1] = static_cast<std::uint8_t>(index & 0xFFU);
        bytes[2] = static_cast<std::uint8_t>(index >> 8U);
        bytes[3] = subindex;
        return bytes;
      });
}

TEST(SdoServer, AnswersEachOfAnySequenceOfRequestsOnce) {
  const std::uint64_t cases = test::case_count(1'000, 50'000);
  setenv("RC_PARAMS", ("max_size=60 max_success=" + std::to_string(cases)).c_str(), 0);
  const auto any_event = rc::gen::build<SdoEvent>(
      rc::gen::set(&SdoEvent::is_answer), rc::gen::set(&SdoEvent::request, any_sdo_request()));
  const bool holds = rc::check("one response or abort for each request", [&any_event] {
    const auto events = *rc::gen::container<std::vector<SdoEvent>>(any_event);
    SdoServerUnderTest sdo;
    std::size_t requests = 0;
    std::size_t responses = 0;
    int answered = 0;
    const auto answer = [&] {
      ++answered;
      responses += sdo.finish({.bytes = "\x01"}).size();
    };
    for (const SdoEvent& event : events) {
      if (event.is_answer) {
        if (answered < sdo.objects.begun) answer();
        continue;
      }
      ++requests;
      sdo.server.receive({.id = 0x601, .size = kMostData, .data = event.request}, sdo.now);
      responses += sdo.host.take().size();
    }
    while (answered < sdo.objects.begun) answer();
    RC_ASSERT(responses == requests);
  });
  EXPECT_TRUE(holds);
}

}  // namespace
}  // namespace vdrive::canopen

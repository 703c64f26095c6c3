// SPDX-License-Identifier: Apache-2.0
// SDO block transfer (CiA 301, 7.2.4.3.9 to 7.2.4.3.16), byte by byte. Node 1: requests 601h,
// responses 581h.
#include "node/sdo_block.hpp"

#include "canopen/served_sdo.hpp"
#include "node/sdo_server.hpp"
#include "support/random_cases.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::uint16_t kDriveNumber = 0x2001;  // 4 bytes, answered later
constexpr std::uint16_t kText = 0x2002;         // `text`

class BlockObjects final : public SdoObjects {
 public:
  [[nodiscard]] SdoTarget check_download(ObjectAddress object) const override {
    if (object.index == kText) return {.abort = AbortCode::write_of_read_only_object};
    return {.size = 4};
  }

  std::optional<SdoAnswer> begin_upload(ObjectAddress object) override {
    if (object.index == kDriveNumber) return std::nullopt;
    if (object.index == kText) return SdoAnswer{.bytes = text, .is_text = true};
    return SdoAnswer{.bytes = "\x11\x22\x33\x44"};
  }

  std::optional<SdoAnswer> begin_download(ObjectAddress object, std::span<const std::uint8_t> data,
                                          DriveTime /*now*/) override {
    downloaded.assign(data.begin(), data.end());
    if (object.index == kDriveNumber) return std::nullopt;
    return SdoAnswer{};
  }

  std::string text;
  std::vector<std::uint8_t> downloaded;
};

using SdoBlocks = ServedSdo<BlockObjects>;

TEST(SdoCrc, IsThatOfItsCheckValue) {
  EXPECT_EQ(sdo_crc("123456789"), 0x31C3) << "CiA 301, 7.2.4.3.16";
  EXPECT_EQ(sdo_crc(""), 0);
}

// Ten bytes: a segment of seven and one of three with 4 unused bytes (n = 4 in bits 2 to 4: C1h +
// 10h).
TEST(SdoBlockUpload, SendsItsSegmentsThenTheCrc) {
  SdoBlocks sdo;
  sdo.objects.text = "abcdefghij";
  const std::string crc = hex_digits(sdo_crc("abcdefghij"), 4);
  EXPECT_THAT(sdo.request("A4 02 20 00 7F"), ElementsAre("581#C60220000A000000"));
  EXPECT_THAT(sdo.request("A3"), ElementsAre("581#0161626364656667", "581#8268696A00000000"));
  EXPECT_THAT(sdo.request("A2 02 7F"),
              ElementsAre("581#D1" + crc.substr(2) + crc.substr(0, 2) + "0000000000"));
  EXPECT_THAT(sdo.request("A1"), IsEmpty());
  EXPECT_EQ(sdo.server.next_due(), std::nullopt);
  EXPECT_EQ(sdo.server.counters().aborts, 0U);
}

TEST(SdoBlockUpload, HasNoCrcForAClientThatDoesNotSupportIt) {
  SdoBlocks sdo;
  sdo.objects.text = "abcdefg";
  EXPECT_THAT(sdo.request("A0 02 20 00 7F"), ElementsAre("581#C602200007000000"));
  EXPECT_THAT(sdo.request("A3"), ElementsAre("581#8161626364656667"));
  EXPECT_THAT(sdo.request("A2 01 7F"), ElementsAre("581#C100000000000000"));
}

TEST(SdoBlockUpload, SendsAnEmptyTextAsASegmentWithoutAByte) {
  SdoBlocks sdo;
  EXPECT_THAT(sdo.request("A4 02 20 00 7F"), ElementsAre("581#C602200000000000"));
  EXPECT_THAT(sdo.request("A3"), ElementsAre("581#8100000000000000"));
  EXPECT_THAT(sdo.request("A2 01 7F"), ElementsAre("581#DD00000000000000")) << "7 unused bytes";
}

TEST(SdoBlockUpload, SendsANumberByBlocksAlsoWhereTheClientPermitsAnotherProtocol) {
  SdoBlocks sdo;
  EXPECT_THAT(sdo.request("A4 00 20 00 7F 08"), ElementsAre("581#C600200004000000"));
  EXPECT_THAT(sdo.request("A3"), ElementsAre("581#8111223344000000"));
}

TEST(SdoBlockUpload, BeginsWhenTheDriveHasAnswered) {
  SdoBlocks sdo;
  EXPECT_THAT(sdo.request("A4 01 20 00 7F"), IsEmpty());
  EXPECT_THAT(sdo.finish({.bytes = "\x05\x06"}), ElementsAre("581#C601200002000000"));
  EXPECT_THAT(sdo.request("A3"), ElementsAre("581#8105060000000000"));
}

// 21 bytes in blocks of two segments. The second segment of the first block is lost and repeated in
// the next block, for which the client asks for three segments.
TEST(SdoBlockUpload, SendsOnceMoreWhatTheClientHasNotReceived) {
  SdoBlocks sdo;
  sdo.objects.text = "abcdefghijklmnopqrstu";
  sdo.request("A4 02 20 00 02");
  EXPECT_THAT(sdo.request("A3"), ElementsAre("581#0161626364656667", "581#0268696A6B6C6D6E"));
  EXPECT_THAT(sdo.request("A2 01 03"), ElementsAre("581#0168696A6B6C6D6E", "581#826F707172737475"));
  EXPECT_THAT(sdo.request("A2 00 03"), SizeIs(2)) << "neither has come";
  EXPECT_THAT(sdo.request("A2 02 03"), ElementsAre(testing::StartsWith("581#C1")));
}

TEST(SdoBlockUpload, RefusesBlocksOfNoOrTooManySegmentsWith05040002) {
  SdoBlocks sdo;
  EXPECT_THAT(sdo.request("A4 02 20 00 00"), ElementsAre("581#8002200002000405"));
  EXPECT_THAT(sdo.request("A4 02 20 00 80"), ElementsAre("581#8002200002000405"));
  sdo.objects.text = std::string(20, 'x');
  sdo.request("A4 02 20 00 01");
  sdo.request("A3");
  EXPECT_THAT(sdo.request("A2 01 80"), ElementsAre("581#8002200002000405"));
}

TEST(SdoBlockUpload, RefusesTheConfirmationOfMoreThanWasSentWith05040003) {
  SdoBlocks sdo;
  sdo.objects.text = std::string(20, 'x');
  sdo.request("A4 02 20 00 02");
  sdo.request("A3");
  EXPECT_THAT(sdo.request("A2 03 02"), ElementsAre("581#8002200003000405"));
  EXPECT_THAT(sdo.request("A3"), ElementsAre("581#8000000001000405")) << "the transfer has ended";
}

TEST(SdoBlockUpload, EndsWithARequestThatItDoesNotExpect) {
  for (const std::string request : {"A2 01 7F", "A1", "C1", "60"}) {
    SdoBlocks sdo;
    sdo.request("A4 02 20 00 7F");
    EXPECT_THAT(sdo.request(request), ElementsAre("581#8002200001000405")) << request;
  }
}

TEST(SdoBlockUpload, EndsWithAnAbortOfTheClientAndWithANewTransfer) {
  SdoBlocks sdo;
  sdo.request("A4 02 20 00 7F");
  EXPECT_THAT(sdo.request("80 02 20 00"), IsEmpty());
  EXPECT_THAT(sdo.request("A3"), ElementsAre("581#8000000001000405"));
  sdo.request("A4 02 20 00 7F");
  EXPECT_THAT(sdo.request("40 00 20 00"), ElementsAre("581#4300200011223344"));
  EXPECT_THAT(sdo.request("A3"), ElementsAre("581#8000000001000405"));
}

TEST(SdoBlockUpload, IsAbortedWhenTheClientDoesNotContinueForASecond) {
  SdoBlocks sdo;
  sdo.objects.text = std::string(20, 'x');
  sdo.request("A4 02 20 00 01");
  sdo.now = 900ms;
  sdo.request("A3");
  EXPECT_THAT(sdo.advance(1'899ms), IsEmpty());
  EXPECT_THAT(sdo.advance(1'900ms), ElementsAre("581#8002200000000405"));
  EXPECT_EQ(sdo.server.counters().time_outs, 1U);
}

// n = 3 unused bytes in the only segment: C1h + 0Ch.
TEST(SdoBlockDownload, WritesWhatCameWhenTheCrcIsRight) {
  SdoBlocks sdo;
  const std::string crc = hex_digits(sdo_crc("\x01\x02\x03\x04"), 4);
  EXPECT_THAT(sdo.request("C6 00 20 00 04"), ElementsAre("581#A40020007F000000"));
  EXPECT_THAT(sdo.request("81 01 02 03 04"), ElementsAre("581#A2017F0000000000"));
  EXPECT_THAT(sdo.request("CD" + crc.substr(2) + crc.substr(0, 2)),
              ElementsAre("581#A100000000000000"));
  EXPECT_THAT(sdo.objects.downloaded, ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(sdo.server.next_due(), std::nullopt);
}

TEST(SdoBlockDownload, IsAnsweredAtItsEndWhenTheDriveHasTakenIt) {
  SdoBlocks sdo;
  sdo.request("C2 01 20 00 04");
  sdo.request("81 01 02 03 04");
  EXPECT_THAT(sdo.request("CD"), IsEmpty()) << "without a CRC, which the client does not support";
  EXPECT_THAT(sdo.finish({}), ElementsAre("581#A100000000000000"));
}

TEST(SdoBlockDownload, RefusesAWrongCrcWith05040004AndWritesNothing) {
  SdoBlocks sdo;
  sdo.request("C6 00 20 00 04");
  sdo.request("81 01 02 03 04");
  EXPECT_THAT(sdo.request("CD FF FF"), ElementsAre("581#8000200004000405"));
  EXPECT_THAT(sdo.objects.downloaded, IsEmpty());
}

TEST(SdoBlockDownload, RefusesAnotherSizeThanThatOfTheObject) {
  SdoBlocks sdo;
  EXPECT_THAT(sdo.request("C6 00 20 00 05"), ElementsAre("581#8000200012000706"));
  EXPECT_THAT(sdo.request("C6 00 20 00 03"), ElementsAre("581#8000200013000706"));
  sdo.request("C0 00 20 00");
  sdo.request("81 01 02 03 04");
  EXPECT_THAT(sdo.request("C9"), ElementsAre("581#8000200012000706")) << "2 unused: five bytes";
  sdo.request("C0 00 20 00");
  sdo.request("81 01 02 03 04");
  EXPECT_THAT(sdo.request("D1"), ElementsAre("581#8000200013000706")) << "4 unused: three bytes";
  sdo.request("C0 00 20 00");
  sdo.request("01 01 02 03 04 05 06 07");
  EXPECT_THAT(sdo.request("02 01"), ElementsAre("581#8000200012000706")) << "eight bytes at least";
}

TEST(SdoBlockDownload, RefusesTheNumberZeroOfASegmentWith05040003) {
  SdoBlocks sdo;
  sdo.request("C6 00 20 00 04");
  EXPECT_THAT(sdo.request("00 01 02 03 04"), ElementsAre("581#8000200003000405"));
}

TEST(SdoBlockDownload, AsksForASegmentThatIsMissing) {
  SdoBlocks sdo;
  sdo.request("C6 00 20 00 04");
  EXPECT_THAT(sdo.request("82 01 02 03 04"), ElementsAre("581#A2007F0000000000"))
      << "the second one, without the first";
  EXPECT_THAT(sdo.request("81 01 02 03 04"), ElementsAre("581#A2017F0000000000"));
}

// The three highest bits of a last segment with a number from 1 to 31 are those of an abort.
TEST(SdoBlockDownload, TakesEveryFrameOfABlockButAnAbortForASegment) {
  SdoBlocks sdo;
  sdo.request("C6 00 20 00 04");
  EXPECT_THAT(sdo.request("80 00 20 00 00 00 04 05"), IsEmpty());
  EXPECT_THAT(sdo.request("81 01 02 03 04"), IsEmpty()) << "an abort of no transfer";
  EXPECT_THAT(sdo.request("40 00 20 00"), ElementsAre("581#4300200011223344"));
}

TEST(SdoBlockDownload, ToAReadOnlyObjectIsRefused) {
  SdoBlocks sdo;
  EXPECT_THAT(sdo.request("C6 02 20 00 04"), ElementsAre("581#8002200002000106"));
}

// Whichever segments the client misses: a completed transfer has delivered the right bytes.
TEST(SdoBlockUpload, BringsEveryTextWholeOverAnyBus) {
  test::Random random(309);
  const auto any_block_size = [&random] {
    return hex_digits(static_cast<std::uint32_t>(1 + random.below(127)), 2);
  };
  for (std::uint64_t i = test::case_count(300, 5'000); i > 0; --i) {
    SdoBlocks sdo;
    for (std::size_t left = random.below(400); left > 0; --left) {
      sdo.objects.text += static_cast<char>('a' + random.below(26));
    }
    sdo.request("A4 02 20 00 " + any_block_size());
    std::string received;
    std::vector<std::string> frames = sdo.request("A3");
    while (!frames.empty() && frame_of(frames.front()).data[0] >> 5U != 6) {
      std::uint32_t taken = 0;
      for (const std::string& text : frames) {
        const Frame frame = frame_of(text);
        if ((frame.data[0] & 0x7FU) != taken + 1 || random.one_in(10)) continue;
        ++taken;
        for (std::size_t byte = 1; byte < kMostData; ++byte) {
          received += static_cast<char>(frame.data.at(byte));
        }
      }
      frames = sdo.request("A2" + hex_digits(taken, 2) + any_block_size());
    }
    ASSERT_THAT(frames, SizeIs(1));
    const Frame end = frame_of(frames.front());
    received.resize(received.size() - (end.data[0] >> 2U & 0x07U));
    EXPECT_EQ(received, sdo.objects.text);
    EXPECT_EQ(end.data[1] | end.data[2] << 8U, sdo_crc(received));
  }
}

}  // namespace
}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
#include "bus/sdo_client.hpp"

#include "canopen/recorded_port.hpp"
#include "support/random_cases.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr ObjectAddress kStatusword{.index = 0x6041, .subindex = 0};
constexpr std::chrono::milliseconds kTimeOut{500};

/// A client of node 5, and the frames it has sent.
struct RecordedClient final : FrameSender {
  void send(const Frame& frame) override { sent.push_back(frame); }

  /// @return the latest frame sent.
  [[nodiscard]] Frame last() const { return sent.empty() ? Frame{} : sent.back(); }

  /// Delivers a frame of node 5.
  void answer(std::initializer_list<std::uint8_t> bytes) {
    client.receive(data_frame(0x585, bytes), now);
  }

  Frames sent;
  BusTime now{std::chrono::seconds(7)};
  SdoClient client{5, *this};
};

SdoOutcome value_of(Bytes data) {
  return {.abort = AbortCode::none, .data = std::move(data)};
}

SdoOutcome abort_of(AbortCode code) {
  return {.abort = code, .data = {}};
}

Frame abort_frame(AbortCode code) {
  const std::uint32_t number = wire_code(code);
  return data_frame(
      0x605, {0x80, 0x41, 0x60, 0x00, static_cast<std::uint8_t>(number),
              static_cast<std::uint8_t>(number >> 8U), static_cast<std::uint8_t>(number >> 16U),
              static_cast<std::uint8_t>(number >> 24U)});
}

// ---- reading (CiA 301, 7.2.4.3.3: SDO upload)

TEST(SdoClient, ReadsAValueOf2BytesExpedited) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  EXPECT_EQ(recorded.sent, Frames{data_frame(0x605, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0})});
  EXPECT_EQ(recorded.client.take_outcome(), std::nullopt);
  // 4Bh: expedited, 2 of 4 bytes unused.
  recorded.answer({0x4B, 0x41, 0x60, 0x00, 0x50, 0x02, 0, 0});
  EXPECT_EQ(recorded.client.take_outcome(), value_of({0x50, 0x02}));
  EXPECT_EQ(recorded.client.take_outcome(), std::nullopt) << "an outcome is taken once";
}

struct ExpeditedRow {
  std::uint8_t command;
  Bytes value;
};

TEST(SdoClient, ReadsAsManyBytesAsTheAnswerHas) {
  for (const ExpeditedRow& row : {ExpeditedRow{0x4F, {1}}, ExpeditedRow{0x4B, {1, 2}},
                                  ExpeditedRow{0x47, {1, 2, 3}}, ExpeditedRow{0x43, {1, 2, 3, 4}},
                                  // Without an indicated size, all 4 bytes are the value.
                                  ExpeditedRow{0x42, {1, 2, 3, 4}}}) {
    RecordedClient recorded;
    recorded.client.read(kStatusword, kTimeOut, recorded.now);
    recorded.answer({row.command, 0x41, 0x60, 0x00, 1, 2, 3, 4});
    EXPECT_EQ(recorded.client.take_outcome(), value_of(row.value)) << int{row.command};
  }
}

TEST(SdoClient, ReadsATextInSegments) {
  RecordedClient recorded;
  recorded.client.read({.index = 0x1008, .subindex = 0}, kTimeOut, recorded.now);
  recorded.answer({0x41, 0x08, 0x10, 0x00, 10, 0, 0, 0});
  EXPECT_EQ(recorded.last(), data_frame(0x605, {0x60, 0, 0, 0, 0, 0, 0, 0}));
  recorded.answer({0x00, 'v', 'i', 'r', 't', 'u', 'a', 'l'});
  EXPECT_EQ(recorded.last(), data_frame(0x605, {0x70, 0, 0, 0, 0, 0, 0, 0}));
  // 19h: toggle, 4 of 7 bytes unused, last.
  recorded.answer({0x19, 'd', 'r', 'v', 0, 0, 0, 0});
  EXPECT_EQ(recorded.client.take_outcome(),
            value_of({'v', 'i', 'r', 't', 'u', 'a', 'l', 'd', 'r', 'v'}));
}

TEST(SdoClient, ReadsSegmentsWithoutAnAnnouncedSize) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.answer({0x40, 0x41, 0x60, 0x00, 0, 0, 0, 0});
  recorded.answer({0x0D, 7, 0, 0, 0, 0, 0, 0});  // 1 byte, last
  EXPECT_EQ(recorded.client.take_outcome(), value_of({7}));
}

TEST(SdoClient, AbortsWhenTheToggleBitDoesNotAlternate) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.answer({0x41, 0x41, 0x60, 0x00, 10, 0, 0, 0});
  recorded.answer({0x10, 1, 2, 3, 4, 5, 6, 7});
  EXPECT_EQ(recorded.last(), abort_frame(AbortCode::toggle_bit_not_alternated));
  EXPECT_EQ(recorded.client.take_outcome(), abort_of(AbortCode::toggle_bit_not_alternated));
}

TEST(SdoClient, AbortsSegmentsThatAreNotAsLongAsAnnounced) {
  RecordedClient longer;
  longer.client.read(kStatusword, kTimeOut, longer.now);
  longer.answer({0x41, 0x41, 0x60, 0x00, 5, 0, 0, 0});
  longer.answer({0x00, 1, 2, 3, 4, 5, 6, 7});
  EXPECT_EQ(longer.last(), abort_frame(AbortCode::length_too_high));
  EXPECT_EQ(longer.client.take_outcome(), abort_of(AbortCode::length_too_high));
  RecordedClient shorter;
  shorter.client.read(kStatusword, kTimeOut, shorter.now);
  shorter.answer({0x41, 0x41, 0x60, 0x00, 5, 0, 0, 0});
  shorter.answer({0x09, 1, 2, 3, 0, 0, 0, 0});
  EXPECT_EQ(shorter.client.take_outcome(), abort_of(AbortCode::data_length_does_not_match));
}

TEST(SdoClient, AllocatesNothingForALengthThatIsAnnounced) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.answer({0x41, 0x41, 0x60, 0x00, 0xFF, 0xFF, 0xFF, 0xFF});
  EXPECT_EQ(recorded.last(), abort_frame(AbortCode::out_of_memory));
  EXPECT_EQ(recorded.client.take_outcome(), abort_of(AbortCode::out_of_memory));
}

TEST(SdoClient, EndsANodeThatSendsSegmentsWithoutEnd) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.answer({0x40, 0x41, 0x60, 0x00, 0, 0, 0, 0});
  std::size_t segments = 0;
  for (std::uint8_t toggle = 0; recorded.client.next_due();
       toggle = static_cast<std::uint8_t>(toggle ^ 0x10U)) {
    recorded.answer({toggle, 1, 2, 3, 4, 5, 6, 7});
    ASSERT_LE(++segments, SdoClient::kLongestValue);
  }
  EXPECT_EQ(segments, SdoClient::kLongestValue / 7 + 1);
  EXPECT_EQ(recorded.client.take_outcome(), abort_of(AbortCode::length_too_high));
}

// ---- writing (CiA 301, 7.2.4.3.1: SDO download)

TEST(SdoClient, WritesUpTo4BytesExpedited) {
  for (const ExpeditedRow& row :
       {ExpeditedRow{0x2F, {1}}, ExpeditedRow{0x2B, {1, 2}}, ExpeditedRow{0x27, {1, 2, 3}},
        ExpeditedRow{0x23, {1, 2, 3, 4}}}) {
    RecordedClient recorded;
    recorded.client.write(kStatusword, row.value, kTimeOut, recorded.now);
    Frame expected = data_frame(0x605, {row.command, 0x41, 0x60, 0, 0, 0, 0, 0});
    std::ranges::copy(row.value, expected.data.begin() + 4);
    EXPECT_EQ(recorded.sent, Frames{expected});
    recorded.answer({0x60, 0x41, 0x60, 0x00, 0, 0, 0, 0});
    EXPECT_EQ(recorded.client.take_outcome(), value_of({}));
  }
}

TEST(SdoClient, WritesLongerValuesInSegments) {
  RecordedClient recorded;
  recorded.client.write(kStatusword, {1, 2, 3, 4, 5, 6, 7, 8, 9}, kTimeOut, recorded.now);
  EXPECT_EQ(recorded.last(), data_frame(0x605, {0x21, 0x41, 0x60, 0x00, 9, 0, 0, 0}));
  recorded.answer({0x60, 0x41, 0x60, 0x00, 0, 0, 0, 0});
  EXPECT_EQ(recorded.last(), data_frame(0x605, {0x00, 1, 2, 3, 4, 5, 6, 7}));
  recorded.answer({0x20, 0, 0, 0, 0, 0, 0, 0});
  // 1Bh: toggle, 5 of 7 bytes unused, last.
  EXPECT_EQ(recorded.last(), data_frame(0x605, {0x1B, 8, 9, 0, 0, 0, 0, 0}));
  recorded.answer({0x30, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(recorded.client.take_outcome(), value_of({}));
}

TEST(SdoClient, WritesAValueOfNoBytesInAnEmptySegment) {
  RecordedClient recorded;
  recorded.client.write(kStatusword, {}, kTimeOut, recorded.now);
  EXPECT_EQ(recorded.last(), data_frame(0x605, {0x21, 0x41, 0x60, 0x00, 0, 0, 0, 0}));
  recorded.answer({0x60, 0x41, 0x60, 0x00, 0, 0, 0, 0});
  EXPECT_EQ(recorded.last(), data_frame(0x605, {0x0F, 0, 0, 0, 0, 0, 0, 0}));
  recorded.answer({0x20, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(recorded.client.take_outcome(), value_of({}));
}

TEST(SdoClient, WritesSegmentsThatFillTheirFrames) {
  RecordedClient recorded;
  recorded.client.write(kStatusword, Bytes(14, 9), kTimeOut, recorded.now);
  recorded.answer({0x60, 0x41, 0x60, 0x00, 0, 0, 0, 0});
  recorded.answer({0x20, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(recorded.last(), data_frame(0x605, {0x11, 9, 9, 9, 9, 9, 9, 9}));
  recorded.answer({0x30, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(recorded.client.take_outcome(), value_of({}));
  EXPECT_EQ(recorded.sent.size(), 3U);
}

TEST(SdoClient, AbortsAWrongToggleBitOfAWrittenSegment) {
  RecordedClient recorded;
  recorded.client.write(kStatusword, Bytes(9, 1), kTimeOut, recorded.now);
  recorded.answer({0x60, 0x41, 0x60, 0x00, 0, 0, 0, 0});
  recorded.answer({0x30, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(recorded.client.take_outcome(), abort_of(AbortCode::toggle_bit_not_alternated));
}

// ---- the end of a transfer

TEST(SdoClient, EndsWithTheAbortOfTheNode) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.answer({0x80, 0x41, 0x60, 0x00, 0x00, 0x00, 0x02, 0x06});
  EXPECT_EQ(recorded.client.take_outcome(), abort_of(AbortCode::object_does_not_exist));
  EXPECT_EQ(recorded.sent.size(), 1U) << "an abort has no answer";
}

TEST(SdoClient, KeepsAnAbortCodeThatItDoesNotKnow) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.answer({0x80, 0x41, 0x60, 0x00, 0x78, 0x56, 0x34, 0x12});
  EXPECT_EQ(recorded.client.take_outcome(), abort_of(static_cast<AbortCode>(0x12345678)));
}

TEST(SdoClient, EndsWhenTheAnswerIsOverdue) {
  RecordedClient recorded;
  EXPECT_EQ(recorded.client.next_due(), std::nullopt);
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  EXPECT_EQ(recorded.client.next_due(), recorded.now + kTimeOut);
  recorded.client.advance(recorded.now + kTimeOut - BusTime(1));
  EXPECT_EQ(recorded.client.take_outcome(), std::nullopt);
  recorded.client.advance(recorded.now + kTimeOut);
  EXPECT_EQ(recorded.last(), abort_frame(AbortCode::protocol_timed_out));
  EXPECT_EQ(recorded.client.take_outcome(), abort_of(AbortCode::protocol_timed_out));
  EXPECT_EQ(recorded.client.next_due(), std::nullopt);
}

TEST(SdoClient, RestartsTheTimeOutForEachAnswer) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.now += std::chrono::milliseconds(400);
  recorded.answer({0x41, 0x41, 0x60, 0x00, 10, 0, 0, 0});
  EXPECT_EQ(recorded.client.next_due(), recorded.now + kTimeOut);
}

TEST(SdoClient, TellsTheNodeWhenATransferIsCancelled) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.client.cancel(AbortCode::cannot_store_or_transfer);
  EXPECT_EQ(recorded.last(), abort_frame(AbortCode::cannot_store_or_transfer));
  EXPECT_EQ(recorded.client.take_outcome(), std::nullopt);
  EXPECT_EQ(recorded.client.next_due(), std::nullopt);
  recorded.client.cancel(AbortCode::general_error);
  EXPECT_EQ(recorded.sent.size(), 2U) << "there is nothing to cancel";
}

TEST(SdoClient, AbortsAnAnswerOfTheWrongKind) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.answer({0x60, 0x41, 0x60, 0x00, 0, 0, 0, 0});  // the answer to a download
  EXPECT_EQ(recorded.last(), abort_frame(AbortCode::unknown_command_specifier));
  EXPECT_EQ(recorded.client.take_outcome(), abort_of(AbortCode::unknown_command_specifier));
}

TEST(SdoClient, IgnoresWhatBelongsToAnotherTransfer) {
  RecordedClient recorded;
  recorded.answer({0x4B, 0x41, 0x60, 0x00, 1, 2, 0, 0});  // no transfer is in progress
  EXPECT_EQ(recorded.client.take_outcome(), std::nullopt);
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  recorded.answer({0x4B, 0x40, 0x60, 0x00, 1, 2, 0, 0});              // another index
  recorded.answer({0x4B, 0x41, 0x60, 0x01, 1, 2, 0, 0});              // another sub-index
  recorded.answer({0x80, 0x40, 0x60, 0x00, 0x00, 0x00, 0x02, 0x06});  // a late abort
  EXPECT_EQ(recorded.client.take_outcome(), std::nullopt);
  recorded.answer({0x4B, 0x41, 0x60, 0x00, 3, 4, 0, 0});
  EXPECT_EQ(recorded.client.take_outcome(), value_of({3, 4}));
}

TEST(SdoClient, IgnoresFramesThatAreNoAnswersOfItsNode) {
  RecordedClient recorded;
  recorded.client.read(kStatusword, kTimeOut, recorded.now);
  const Frame right = data_frame(0x585, {0x4B, 0x41, 0x60, 0x00, 1, 2, 0, 0});
  Frame other_node = right;
  other_node.id = 0x586;
  Frame extended = right;
  extended.is_extended = true;
  Frame remote = right;
  remote.is_remote = true;
  Frame too_short = right;
  too_short.size = 7;
  for (const Frame& frame : {other_node, extended, remote, too_short}) {
    EXPECT_FALSE(recorded.client.is_for(frame));
    recorded.client.receive(frame, recorded.now);
    EXPECT_EQ(recorded.client.take_outcome(), std::nullopt);
  }
  EXPECT_TRUE(recorded.client.is_for(right));
}

TEST(SdoClient, EndsOnceForAnyAnswers) {
  test::Random random(301);
  const std::uint64_t cases = test::case_count(2'000, 100'000);
  for (std::uint64_t i = 0; i < cases; ++i) {
    RecordedClient recorded;
    const bool is_read = random.one_in(2);
    if (is_read) {
      recorded.client.read(kStatusword, kTimeOut, recorded.now);
    } else {
      recorded.client.write(kStatusword, Bytes(random.below(20), 1), kTimeOut, recorded.now);
    }
    std::optional<SdoOutcome> outcome;
    for (int n = 0; n < 40 && !outcome; ++n) {
      Frame frame = data_frame(0x585, {0, 0x41, 0x60, 0, 0, 0, 0, 0});
      frame.data[0] = static_cast<std::uint8_t>(random.below(256));
      for (std::size_t byte = 4; byte < kMostData; ++byte) {
        frame.data.at(byte) = static_cast<std::uint8_t>(random.below(4));
      }
      recorded.client.receive(frame, recorded.now);
      outcome = recorded.client.take_outcome();
    }
    recorded.client.advance(recorded.now + kTimeOut);
    const auto last = recorded.client.take_outcome();
    ASSERT_NE(outcome.has_value(), last.has_value());
    ASSERT_EQ(recorded.client.next_due(), std::nullopt);
  }
}

}  // namespace
}  // namespace vdrive::canopen

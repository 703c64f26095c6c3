// SPDX-License-Identifier: Apache-2.0
#include "bus/socketcand.hpp"

#include "canopen/recorded_port.hpp"
#include "support/random_cases.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::canopen {
namespace {

using Replies = std::vector<std::string>;

/// A session, its answers and the frames it sent.
struct RecordedSession final : SocketcandHost {
  void reply(std::string_view text) override { replies.emplace_back(text); }

  void send(const Frame& frame) override { frames.push_back(frame); }

  /// Feeds `bytes` to the session and returns the answers.
  Replies take(std::string_view bytes) {
    replies.clear();
    session.take(bytes);
    return replies;
  }

  Replies replies;
  Frames frames;
  SocketcandSession session{*this};
};

RecordedSession& in_raw_mode(RecordedSession& recorded) {
  recorded.take("< open can0 >< rawmode >");
  return recorded;
}

std::string frame_text(const Frame& frame, std::chrono::microseconds time) {
  std::string text;
  append_socketcand_frame(text, frame, time);
  return text;
}

/// The notation of python-can: bytes without leading zeros.
std::string send_text(const Frame& frame) {
  std::string text = frame.is_remote ? "< sendrtr " : "< send ";
  std::array<char, 16> part{};
  std::snprintf(part.data(), part.size(), "%0*X", frame.is_extended ? 8 : 3, frame.id);
  text += part.data();
  text += " " + std::to_string(frame.size) + " ";
  for (const std::uint8_t byte : frame.bytes()) {
    std::snprintf(part.data(), part.size(), "%x ", unsigned{byte});
    text += part.data();
  }
  return text + ">";
}

Frame random_frame(test::Random& random) {
  Frame frame;
  frame.is_extended = random.one_in(3);
  frame.is_remote = random.one_in(5);
  const std::uint32_t highest = frame.is_extended ? kHighestExtendedId : kHighestBaseId;
  frame.id = static_cast<std::uint32_t>(random.below(highest + 1U));
  frame.size = static_cast<std::uint8_t>(random.below(kMostData + 1));
  for (std::size_t i = 0; i < frame.bytes().size(); ++i) {
    frame.data.at(i) = static_cast<std::uint8_t>(random.below(256));
  }
  return frame;
}

// ---- frames for clients

TEST(SocketcandFrame, HasContiguousBytesAndMicroseconds) {
  EXPECT_EQ(frame_text(data_frame(0x123, {0x11, 0x22, 0x0A, 0xFF}),
                       std::chrono::microseconds(23'424'242)),
            "\n< frame 123 23.424242 11220AFF >");
}

TEST(SocketcandFrame, HasExactlyThreeDigitsInTheBaseFormat) {
  // Newer versions of python-can take any other number of digits for the extended format.
  EXPECT_EQ(frame_text(data_frame(0x1, {0}), std::chrono::microseconds(7)),
            "\n< frame 001 0.000007 00 >");
}

TEST(SocketcandFrame, HasEightDigitsInTheExtendedFormat) {
  Frame frame = data_frame(0x81, {1});
  frame.is_extended = true;
  EXPECT_EQ(frame_text(frame, {}), "\n< frame 00000081 0.000000 01 >");
}

TEST(SocketcandFrame, HasTwoSpacesInPlaceOfNoData) {
  // python-can takes the third field for the data; it is missing without the second space.
  EXPECT_EQ(frame_text(data_frame(0x080, {}), std::chrono::seconds(1)),
            "\n< frame 080 1.000000  >");
}

TEST(SocketcandFrame, NamesTheLengthOfARemoteFrame) {
  const Frame frame{.id = 0x701, .is_remote = true, .size = 1};
  EXPECT_EQ(frame_text(frame, std::chrono::microseconds(23'424'242)), "\n< rtr 701 23.424242 1 >");
}

TEST(SocketcandFrame, TakesATimeBelow0For0) {
  EXPECT_EQ(frame_text(data_frame(0x080, {1}), std::chrono::microseconds(-1)),
            "\n< frame 080 0.000000 01 >");
}

TEST(SocketcandStatistics, HasReceivedBeforeSent) {
  EXPECT_EQ(socketcand_statistics(
                {.received_bytes = 1, .received_frames = 2, .sent_bytes = 3, .sent_frames = 4}),
            "< stat 1 2 3 4 >");
}

// ---- opening and modes

TEST(SocketcandSession, OpensABusAndGoesThroughTheModes) {
  RecordedSession recorded;
  EXPECT_EQ(recorded.session.mode(), SocketcandMode::no_bus);
  EXPECT_EQ(recorded.take("< open can0 >"), Replies{"< ok >"});
  EXPECT_EQ(recorded.session.mode(), SocketcandMode::bcm);
  EXPECT_EQ(recorded.take("< rawmode >"), Replies{"< ok >"});
  EXPECT_EQ(recorded.session.mode(), SocketcandMode::raw);
  EXPECT_EQ(recorded.take("< controlmode >"), Replies{"< ok >"});
  EXPECT_EQ(recorded.session.mode(), SocketcandMode::control);
  EXPECT_EQ(recorded.take("< bcmmode >"), Replies{"< ok >"});
  EXPECT_EQ(recorded.session.mode(), SocketcandMode::bcm);
}

TEST(SocketcandSession, AnswersAWordOfTheModeItIsIn) {
  RecordedSession recorded;
  EXPECT_EQ(in_raw_mode(recorded).take("< rawmode >"), Replies{"< ok >"});
}

TEST(SocketcandSession, OpensABusOfAnyName) {
  for (const char* const name : {"can0", "vcan0", "can1", "slcan0", "a", "sixteen-letters-"}) {
    RecordedSession recorded;
    EXPECT_EQ(recorded.take("< open " + std::string(name) + " >"), Replies{"< ok >"}) << name;
  }
}

TEST(SocketcandSession, EndsWhereTheBusHasNoName) {
  for (const char* const word :
       {"< open >", "< open can0 can1 >", "< open seventeen-letters >", "< open c\x01n0 >"}) {
    RecordedSession recorded;
    EXPECT_EQ(recorded.take(word), Replies{"< error could not open bus >"}) << word;
    EXPECT_TRUE(recorded.session.is_over());
    EXPECT_EQ(recorded.take("< echo >"), Replies{}) << "what follows is not read";
  }
}

TEST(SocketcandSession, SendsNothingBeforeABusIsOpen) {
  RecordedSession recorded;
  EXPECT_EQ(recorded.take("< send 123 0 >"), Replies{"< error open a bus first >"});
  EXPECT_EQ(recorded.take("< rawmode >"), Replies{"< error open a bus first >"});
  EXPECT_EQ(recorded.frames, Frames{});
  EXPECT_EQ(recorded.session.refused_words(), 2U);
  EXPECT_FALSE(recorded.session.is_over());
}

TEST(SocketcandSession, EchoesInEveryMode) {
  RecordedSession recorded;
  EXPECT_EQ(recorded.take("< echo >"), Replies{"< echo >"});
  recorded.take("< open can0 >");
  for (const char* const mode : {"< bcmmode >", "< rawmode >", "< controlmode >"}) {
    recorded.take(mode);
    EXPECT_EQ(recorded.take("< echo >"), Replies{"< echo >"}) << mode;
  }
}

TEST(SocketcandSession, RefusesTheBroadcastManager) {
  RecordedSession recorded;
  recorded.take("< open can0 >");
  for (const char* const word :
       {"< add 1 0 123 1 11 >", "< update 123 1 11 >", "< delete 123 >", "< subscribe 0 0 123 >",
        "< unsubscribe 123 >", "< filter 0 0 123 1 FF >", "< muxfilter 0 0 123 2 FF >"}) {
    EXPECT_EQ(recorded.take(word),
              Replies{"< error broadcast manager is not supported, use rawmode >"})
        << word;
  }
  EXPECT_EQ(recorded.session.refused_words(), 7U);
}

TEST(SocketcandSession, RefusesIsoTpAndFramesOfCanFd) {
  RecordedSession recorded;
  in_raw_mode(recorded);
  EXPECT_EQ(recorded.take("< isotpmode >"), Replies{"< error unknown command >"});
  EXPECT_EQ(recorded.take("< fdsend 123 0 1 11 >"), Replies{"< error unknown command >"});
}

// ---- statistics

TEST(SocketcandSession, HasStatisticsInControlMode) {
  RecordedSession recorded;
  recorded.take("< open can0 >< controlmode >");
  EXPECT_EQ(recorded.take("< statistics 1000 >"), Replies{});
  EXPECT_EQ(recorded.session.statistics_period(), std::chrono::milliseconds(1000));
  recorded.take("< statistics 0 >");
  EXPECT_EQ(recorded.session.statistics_period(), std::chrono::milliseconds(0));
}

TEST(SocketcandSession, BoundsThePeriodOfStatistics) {
  RecordedSession recorded;
  recorded.take("< open can0 >< controlmode >< statistics 1 >");
  EXPECT_EQ(recorded.session.statistics_period(), std::chrono::milliseconds(10));
  recorded.take("< statistics 4294967295 >");
  EXPECT_EQ(recorded.session.statistics_period(), std::chrono::hours(24));
}

TEST(SocketcandSession, EndsStatisticsWithControlMode) {
  RecordedSession recorded;
  recorded.take("< open can0 >< controlmode >< statistics 1000 >< rawmode >");
  EXPECT_EQ(recorded.session.statistics_period(), std::chrono::milliseconds(0));
}

TEST(SocketcandSession, RefusesMalformedStatistics) {
  RecordedSession recorded;
  recorded.take("< open can0 >< controlmode >");
  for (const char* const word :
       {"< statistics >", "< statistics x >", "< statistics 1 2 >", "< statistics -1 >"}) {
    EXPECT_EQ(recorded.take(word), Replies{"< error statistics needs a number of milliseconds >"})
        << word;
  }
  EXPECT_EQ(recorded.take("< send 123 0 >"), Replies{"< error unknown command >"});
}

// ---- frames of clients

TEST(SocketcandSession, SendsFramesInBcmAndRawMode) {
  RecordedSession recorded;
  recorded.take("< open can0 >");
  EXPECT_EQ(recorded.take("< send 601 8 40 0 10 0 0 0 0 0 >"), Replies{});
  recorded.take("< rawmode >");
  EXPECT_EQ(recorded.take("< send 000 2 81 01 >"), Replies{});
  EXPECT_EQ(recorded.frames, (Frames{data_frame(0x601, {0x40, 0, 0x10, 0, 0, 0, 0, 0}),
                                     data_frame(0x000, {0x81, 1})}));
}

TEST(SocketcandSession, TakesOneDigitFewSpacesAndBothLetterCases) {
  RecordedSession recorded;
  in_raw_mode(recorded).take("<send 2a 3 f 0F aB>");
  EXPECT_EQ(recorded.frames, Frames{data_frame(0x02A, {0x0F, 0x0F, 0xAB})});
}

TEST(SocketcandSession, TakesAFrameWithoutDataAsPythonWritesIt) {
  RecordedSession recorded;
  in_raw_mode(recorded).take("< send 080 0  >");
  EXPECT_EQ(recorded.frames, Frames{data_frame(0x080, {})});
}

TEST(SocketcandSession, TakesEightDigitsForTheExtendedFormat) {
  RecordedSession recorded;
  in_raw_mode(recorded).take("< send 1AAAAAAA 2 1 F1 >< send 00000080 0 >");
  Frame first = data_frame(0x1AAAAAAA, {0x01, 0xF1});
  first.is_extended = true;
  Frame second = data_frame(0x80, {});
  second.is_extended = true;
  EXPECT_EQ(recorded.frames, (Frames{first, second}));
}

TEST(SocketcandSession, SendsRemoteFrames) {
  RecordedSession recorded;
  in_raw_mode(recorded).take("< sendrtr 181 8 >");
  EXPECT_EQ(recorded.frames, (Frames{Frame{.id = 0x181, .is_remote = true, .size = 8}}));
}

struct RefusedRow {
  const char* word;
  const char* answer;
};

TEST(SocketcandSession, AnswersMalformedFramesWithTheCauseAndContinues) {
  RecordedSession recorded;
  in_raw_mode(recorded);
  for (const RefusedRow& row : {
           RefusedRow{"< send >", "< error identifier is not 1 to 8 hexadecimal digits >"},
           RefusedRow{"< send 12G 0 >", "< error identifier is not 1 to 8 hexadecimal digits >"},
           RefusedRow{"< send 0x12 0 >", "< error identifier is not 1 to 8 hexadecimal digits >"},
           RefusedRow{"< send -1 0 >", "< error identifier is not 1 to 8 hexadecimal digits >"},
           RefusedRow{"< send 000000123 0 >",
                      "< error identifier is not 1 to 8 hexadecimal digits >"},
           RefusedRow{"< send 20000000 0 >", "< error identifier is above 1FFFFFFF >"},
           RefusedRow{"< send 800 0 >", "< error identifier above 7FF needs eight digits >"},
           RefusedRow{"< send 123 >", "< error length is not a number >"},
           RefusedRow{"< send 123 x >", "< error length is not a number >"},
           RefusedRow{"< send 123 9 1 2 3 4 5 6 7 8 9 >", "< error frame has more than 8 bytes >"},
           RefusedRow{"< send 123 64 >", "< error frame has more than 8 bytes >"},
           RefusedRow{"< send 123 2 1 >", "< error number of bytes is not the length >"},
           RefusedRow{"< send 123 0 1 >", "< error number of bytes is not the length >"},
           RefusedRow{"< send 123 8 1 2 3 4 5 6 7 8 9 >",
                      "< error number of bytes is not the length >"},
           RefusedRow{"< send 123 1 100 >", "< error byte is not hexadecimal >"},
           RefusedRow{"< send 123 1 1x >", "< error byte is not hexadecimal >"},
           RefusedRow{"< sendrtr 123 1 1 >", "< error number of bytes is not the length >"},
           RefusedRow{"< frame 123 1.0 11 >", "< error unknown command >"},
           RefusedRow{"<>", "< error unknown command >"},
           RefusedRow{"< >", "< error unknown command >"},
       }) {
    const std::uint64_t before = recorded.session.refused_words();
    EXPECT_EQ(recorded.take(row.word), Replies{row.answer}) << row.word;
    EXPECT_EQ(recorded.session.refused_words(), before + 1) << row.word;
  }
  EXPECT_EQ(recorded.frames, Frames{});
  recorded.take("< send 123 0 >");
  EXPECT_EQ(recorded.frames, Frames{data_frame(0x123, {})});
}

TEST(SocketcandSession, TakesTheNextWordWhereAnEndWasLost) {
  RecordedSession recorded;
  EXPECT_EQ(in_raw_mode(recorded).take("< send 123 1 < send 124 0 >"),
            Replies{"< error word has no end >"});
  EXPECT_EQ(recorded.frames, Frames{data_frame(0x124, {})});
}

TEST(SocketcandSession, KeepsNoMoreOfAWordThanTheLongestHas) {
  RecordedSession recorded;
  in_raw_mode(recorded);
  const std::string blanks(kLongestSocketcandWord - 12, ' ');
  // The brackets do not count: " send 123 0 " has 12 characters.
  EXPECT_EQ(recorded.take("< send 123 0 " + blanks + ">"), Replies{});
  EXPECT_EQ(recorded.take("< send 123 0  " + blanks + ">"), Replies{"< error word is too long >"});
  EXPECT_EQ(recorded.take("< send " + std::string(100'000, '1') + ">"),
            Replies{"< error word is too long >"});
  EXPECT_EQ(recorded.frames, Frames{data_frame(0x123, {})});
}

TEST(SocketcandSession, IgnoresBytesBetweenWords) {
  RecordedSession recorded;
  EXPECT_EQ(recorded.take("\r\n> GET / < open can0 > \n\n x< rawmode >\n"),
            (Replies{"< ok >", "< ok >"}));
  EXPECT_EQ(recorded.session.refused_words(), 0U);
}

TEST(SocketcandSession, TakesBytesInPartsOfAnyLength) {
  test::Random random(29536);
  const std::uint64_t cases = test::case_count(500, 20'000);
  for (std::uint64_t i = 0; i < cases; ++i) {
    RecordedSession recorded;
    Frames expected;
    std::string text = "< open can0 >< rawmode >";
    for (std::uint64_t frames = random.below(8); frames > 0; --frames) {
      expected.push_back(random_frame(random));
      text += send_text(expected.back());
    }
    for (std::string_view rest = text; !rest.empty();) {
      const std::size_t length = std::min<std::size_t>(1 + random.below(20), rest.size());
      recorded.session.take(rest.substr(0, length));
      rest.remove_prefix(length);
    }
    ASSERT_EQ(recorded.frames, expected) << text;
    ASSERT_EQ(recorded.session.refused_words(), 0U) << text;
  }
}

TEST(SocketcandSession, AnswersEachWordOfAnyBytesOnce) {
  test::Random random(1);
  const std::uint64_t cases = test::case_count(2'000, 100'000);
  constexpr std::string_view kAlphabet = "<<>> send123456789abcxrawmode\n\xFF";
  for (std::uint64_t i = 0; i < cases; ++i) {
    RecordedSession recorded;
    in_raw_mode(recorded);
    std::string text;
    for (std::uint64_t n = random.below(64); n > 0; --n) {
      text += kAlphabet[random.below(kAlphabet.size())];
    }
    recorded.take(text);
    for (const std::string& reply : recorded.replies) {
      ASSERT_TRUE(reply.starts_with("< ") && reply.ends_with(" >")) << reply;
      ASSERT_EQ(reply.find('<', 1), std::string::npos) << reply;
      ASSERT_EQ(reply.find('>'), reply.size() - 1) << reply;
    }
    for (const Frame& frame : recorded.frames) ASSERT_LE(frame.size, kMostData);
  }
}

}  // namespace
}  // namespace vdrive::canopen

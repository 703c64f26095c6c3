// SPDX-License-Identifier: Apache-2.0
#include "bus/ascii_gateway.hpp"

#include "canopen/recorded_port.hpp"
#include "support/random_cases.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vdrive::canopen {
namespace {

using Lines = std::vector<std::string>;
using ValueData = std::vector<std::uint8_t>;

GatewayType type_of(std::string_view name) {
  return find_gateway_type(name).value();
}

// ---- values

struct ValueRow {
  const char* type;
  const char* text;
  ValueData data;
};

const std::vector<ValueRow>& value_rows() {
  static const std::vector<ValueRow> rows{
      {"b", "0", {0}},
      {"b", "1", {1}},
      {"i8", "-128", {0x80}},
      {"i8", "127", {0x7F}},
      {"i16", "-2", {0xFE, 0xFF}},
      {"i32", "-2147483648", {0, 0, 0, 0x80}},
      {"i64", "-9223372036854775808", {0, 0, 0, 0, 0, 0, 0, 0x80}},
      {"i64", "9223372036854775807", {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F}},
      {"u8", "255", {0xFF}},
      {"u16", "592", {0x50, 0x02}},
      {"u32", "4294967295", {0xFF, 0xFF, 0xFF, 0xFF}},
      {"u64", "18446744073709551615", {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}},
      // IEEE 754: 1.5 is 3FC00000h and 3FF8000000000000h.
      {"r32", "1.5", {0, 0, 0xC0, 0x3F}},
      {"r64", "-1.5", {0, 0, 0, 0, 0, 0, 0xF8, 0xBF}},
      // RFC 4648, section 10, and the last character of its alphabet.
      {"os", "", {}},
      {"os", "Zg==", {'f'}},
      {"us", "Zm8=", {'f', 'o'}},
      {"d", "Zm9v", {'f', 'o', 'o'}},
      {"d", "Zm9vYmFy", {'f', 'o', 'o', 'b', 'a', 'r'}},
      {"d", "//79", {0xFF, 0xFE, 0xFD}},
  };
  return rows;
}

TEST(GatewayValue, IsEncodedLittleEndian) {
  for (const ValueRow& row : value_rows()) {
    EXPECT_EQ(encode_value(type_of(row.type), row.text), row.data) << row.type << " " << row.text;
  }
}

TEST(GatewayValue, IsDecodedToTheSameText) {
  for (const ValueRow& row : value_rows()) {
    EXPECT_EQ(decode_value(type_of(row.type), row.data), row.text) << row.type << " " << row.text;
  }
}

TEST(GatewayValue, MayBeHexadecimal) {
  EXPECT_EQ(encode_value(type_of("u16"), "0x6F"), (ValueData{0x6F, 0}));
  EXPECT_EQ(encode_value(type_of("i32"), "-0X10"), (ValueData{0xF0, 0xFF, 0xFF, 0xFF}));
}

TEST(GatewayValue, IsRefusedOutsideOfItsType) {
  for (const ValueRow& row : std::vector<ValueRow>{
           {"b", "2", {}},     {"b", "true", {}},     {"i8", "128", {}},
           {"i8", "-129", {}}, {"i16", "0xFFFF", {}}, {"i64", "9223372036854775808", {}},
           {"u8", "256", {}},  {"u8", "-1", {}},      {"u8", "", {}},
           {"u8", "1.0", {}},  {"u8", "+1", {}},      {"u64", "18446744073709551616", {}},
           {"i8", "-", {}},    {"i8", "--1", {}},     {"r32", "1e39", {}},
           {"r64", "nan", {}}, {"r64", "one", {}},    {"os", "Zg=", {}},
           {"os", "Z===", {}}, {"os", "====", {}},    {"os", "Zg==Zg==", {}},
           {"os", "Z!==", {}}, {"os", "Z=g=", {}}}) {
    EXPECT_EQ(encode_value(type_of(row.type), row.text), std::nullopt)
        << row.type << " " << row.text;
  }
}

TEST(GatewayValue, HasAsManyBytesAsItsType) {
  EXPECT_EQ(decode_value(type_of("u16"), ValueData{1}), std::nullopt);
  EXPECT_EQ(decode_value(type_of("u16"), ValueData{1, 2, 3, 4}), std::nullopt);
  EXPECT_EQ(decode_value(type_of("i8"), ValueData{}), std::nullopt);
}

TEST(GatewayValue, ShowsATextInQuotesWithinOneLine) {
  const auto shown = [](std::string_view text) {
    return decode_value(type_of("vs"), ValueData(text.begin(), text.end())).value();
  };
  EXPECT_EQ(shown("vdrive"), "\"vdrive\"");
  EXPECT_EQ(shown(""), "\"\"");
  EXPECT_EQ(shown("say \"hi\""), R"("say ""hi""")");
  EXPECT_EQ(shown("a\r\nb\x01"), R"("a\r\nb\x01")");
  EXPECT_EQ(shown(std::string_view("filled\0\0", 8)), "\"filled\"");
}

TEST(GatewayValue, WithoutATypeIsHexadecimal) {
  EXPECT_EQ(hex_bytes(ValueData{0x50, 0x02, 0xAB}), "50 02 AB");
  EXPECT_EQ(hex_bytes(ValueData{}), "");
}

TEST(GatewayValue, OfAnyBytesComesBackInBase64) {
  test::Random random(64);
  const std::uint64_t cases = test::case_count(500, 20'000);
  for (std::uint64_t i = 0; i < cases; ++i) {
    ValueData data(random.below(20));
    for (std::uint8_t& byte : data) byte = static_cast<std::uint8_t>(random.below(256));
    const auto text = decode_value(type_of("d"), data);
    ASSERT_TRUE(text);
    ASSERT_EQ(encode_value(type_of("d"), *text), data) << *text;
  }
}

// ---- commands

GatewayCommand command_of(std::string_view line) {
  const auto parsed = parse_gateway_command(line);
  const auto* const command = std::get_if<GatewayCommand>(&parsed);
  EXPECT_NE(command, nullptr) << line;
  return command != nullptr ? *command : GatewayCommand{};
}

TEST(GatewayCommand, ReadsWithNetNodeAndType) {
  const GatewayCommand expected{.sequence = 12,
                                .net = 1,
                                .node = 3,
                                .verb = GatewayVerb::read,
                                .object = {.index = 0x6041, .subindex = 0},
                                .type = type_of("u16")};
  EXPECT_EQ(command_of("[12] 1 3 read 0x6041 0 u16"), expected);
  EXPECT_EQ(command_of("  [12]\t1  3 R 24641 0x0 U16  # the statusword"), expected);
}

TEST(GatewayCommand, TakesASingleNumberForTheNode) {
  const GatewayCommand command = command_of("[1] 5 r 0x1000 0");
  EXPECT_EQ(command.net, std::nullopt);
  EXPECT_EQ(command.node, 5U);
  EXPECT_EQ(command.type, std::nullopt);
}

TEST(GatewayCommand, TakesASingleNumberForTheNetWhereItIsForNoNode) {
  const GatewayCommand command = command_of("[1] 1 set node 4");
  EXPECT_EQ(command.net, 1U);
  EXPECT_EQ(command.node, std::nullopt);
  EXPECT_EQ(command.value, 4U);
}

TEST(GatewayCommand, WritesAValueOfItsType) {
  const GatewayCommand command = command_of("[7] 2 w 0x607A 0 i32 -2");
  EXPECT_EQ(command.verb, GatewayVerb::write);
  EXPECT_EQ(command.object, (ObjectAddress{.index = 0x607A, .subindex = 0}));
  EXPECT_EQ(command.data, (ValueData{0xFE, 0xFF, 0xFF, 0xFF}));
}

TEST(GatewayCommand, WritesATextWithAndWithoutQuotes) {
  const auto text_of = [](std::string_view line) {
    const GatewayCommand command = command_of(line);
    return std::string(command.data.begin(), command.data.end());
  };
  EXPECT_EQ(text_of("[1] 1 w 0x1010 1 vs save"), "save");
  EXPECT_EQ(text_of("[1] 1 w 0x1010 1 vs \"save\" # all"), "save");
  EXPECT_EQ(text_of(R"([1] 1 w 0x2000 0 vs "a ""b"" # c")"), "a \"b\" # c");
  EXPECT_EQ(text_of("[1] 1 w 0x2000 0 vs \"\""), "");
}

struct VerbRow {
  const char* line;
  GatewayVerb verb;
};

TEST(GatewayCommand, KnowsTheWordsOfTheStandard) {
  for (const VerbRow& row : {
           VerbRow{"[1] 1 start", GatewayVerb::start},
           VerbRow{"[1] 1 STOP", GatewayVerb::stop},
           VerbRow{"[1] 1 preop", GatewayVerb::preoperational},
           VerbRow{"[1] 1 preoperational", GatewayVerb::preoperational},
           VerbRow{"[1] 1 reset node", GatewayVerb::reset_node},
           VerbRow{"[1] 1 reset comm", GatewayVerb::reset_communication},
           VerbRow{"[1] 1 Reset Communication", GatewayVerb::reset_communication},
           VerbRow{"[1] set network 1", GatewayVerb::set_network},
           VerbRow{"[1] set node 1", GatewayVerb::set_node},
           VerbRow{"[1] set sdo_timeout 100", GatewayVerb::set_sdo_timeout},
           VerbRow{"[1] boot_up_indication Disable", GatewayVerb::boot_up_indication},
           VerbRow{"[1] info version", GatewayVerb::info_version},
       }) {
    EXPECT_EQ(command_of(row.line).verb, row.verb) << row.line;
  }
}

TEST(GatewayCommand, IsNothingInAnEmptyLineAndAComment) {
  for (const char* const line : {"", "   ", "\t", "\r", "# [1] 1 start", "   # nothing"}) {
    EXPECT_TRUE(std::holds_alternative<std::monostate>(parse_gateway_command(line))) << line;
  }
}

struct RefusedLine {
  const char* line;
  std::uint32_t sequence;
  GatewayError error;
};

TEST(GatewayCommand, IsRefusedWithItsSequenceWhereItHasOne) {
  constexpr GatewayError kSyntax = GatewayError::syntax;
  constexpr GatewayError kUnsupported = GatewayError::not_supported;
  for (const RefusedLine& row : {
           RefusedLine{"1 start", 0, kSyntax},
           RefusedLine{"[] 1 start", 0, kSyntax},
           RefusedLine{"[x] 1 start", 0, kSyntax},
           RefusedLine{"[-1] 1 start", 0, kSyntax},
           RefusedLine{"[4294967296] 1 start", 0, kSyntax},
           RefusedLine{"[5", 0, kSyntax},
           RefusedLine{"[5]", 5, kSyntax},
           RefusedLine{"[5] 1", 5, kSyntax},
           RefusedLine{"[5] 1 2 3 start", 5, kSyntax},
           RefusedLine{"[5] 1x start", 5, kSyntax},
           RefusedLine{"[5] 1 start now", 5, kSyntax},
           RefusedLine{"[5] 1 read", 5, kSyntax},
           RefusedLine{"[5] 1 read 0x6041", 5, kSyntax},
           RefusedLine{"[5] 1 read 0x10000 0", 5, kSyntax},
           RefusedLine{"[5] 1 read 0x6041 256", 5, kSyntax},
           RefusedLine{"[5] 1 read 0x6041 0 u17", 5, kSyntax},
           RefusedLine{"[5] 1 read 0x6041 0 u16 1", 5, kSyntax},
           RefusedLine{"[5] 1 write 0x6040 0 6", 5, kSyntax},
           RefusedLine{"[5] 1 write 0x6040 0 u16", 5, kSyntax},
           RefusedLine{"[5] 1 write 0x6040 0 u16 65536", 5, kSyntax},
           RefusedLine{"[5] 1 write 0x6040 0 u16 6 7", 5, kSyntax},
           RefusedLine{"[5] 1 write 0x1008 0 vs \"open", 5, kSyntax},
           RefusedLine{"[5] 1 write 0x1008 0 vs \"a\"b", 5, kSyntax},
           RefusedLine{"[5] 1 reset", 5, kSyntax},
           RefusedLine{"[5] set node", 5, kSyntax},
           RefusedLine{"[5] 1 1 set node 1", 5, kSyntax},
           RefusedLine{"[5] 1 set network 1", 5, kSyntax},
           RefusedLine{"[5] set node 4294967296", 5, kSyntax},
           RefusedLine{"[5] boot_up_indication maybe", 5, kSyntax},
           RefusedLine{"[5] 1 dance", 5, kUnsupported},
           RefusedLine{"[5] 1 reset drive", 5, kUnsupported},
           RefusedLine{"[5] set tpdox 1", 5, kUnsupported},
           RefusedLine{"[5] lss_store", 5, kUnsupported},
       }) {
    const auto parsed = parse_gateway_command(row.line);
    const auto* const refusal = std::get_if<GatewayRefusal>(&parsed);
    ASSERT_NE(refusal, nullptr) << row.line;
    EXPECT_EQ(*refusal, (GatewayRefusal{.sequence = row.sequence, .error = row.error})) << row.line;
  }
}

// ---- the gateway

/// A gateway of network 1, with the frames it sent and the answers to its first session.
struct RecordedGateway final : GatewayHost {
  explicit RecordedGateway(const GatewaySettings& settings = {}) : gateway(settings, *this) {
    first = gateway.open();
  }

  void send(const Frame& frame) override { sent.push_back(frame); }

  void answer(GatewaySession session, std::string_view line) override {
    (session == first ? answers : others).emplace_back(line);
  }

  void report(GatewaySession session, std::string_view line) override {
    (session == first ? reports : others).emplace_back(line);
  }

  std::optional<std::string> disturb(std::uint8_t /*node*/, std::string_view /*fault*/) override {
    return std::nullopt;
  }

  /// @return the immediate answers to this line in the first session.
  Lines take(std::string_view line) {
    answers.clear();
    gateway.take_line(first, line, now);
    return answers;
  }

  /// @return the answers in the first session after this response of a node.
  Lines receive(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
    answers.clear();
    const Frame frame = data_frame(id, bytes);
    EXPECT_TRUE(gateway.awaits(frame));
    gateway.receive(frame, now);
    return answers;
  }

  Lines answers;
  Lines reports;
  Lines others;  ///< answers to other sessions
  Frames sent;
  BusTime now{};
  GatewaySession first = 0;
  AsciiGateway gateway;
};

TEST(AsciiGateway, ReadsAnObject) {
  RecordedGateway recorded;
  EXPECT_EQ(recorded.take("[1] 3 r 0x6041 0 u16"), Lines{});
  EXPECT_EQ(recorded.sent, Frames{data_frame(0x603, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0})});
  EXPECT_EQ(recorded.receive(0x583, {0x4B, 0x41, 0x60, 0, 0x50, 0x02, 0, 0}), Lines{"[1] 592"});
}

TEST(AsciiGateway, ReadsBytesWithoutAType) {
  RecordedGateway recorded;
  recorded.take("[2] 3 r 0x6041 0");
  EXPECT_EQ(recorded.receive(0x583, {0x4B, 0x41, 0x60, 0, 0x50, 0x02, 0, 0}), Lines{"[2] 50 02"});
}

TEST(AsciiGateway, WritesAnObject) {
  RecordedGateway recorded;
  recorded.take("[3] 1 3 w 0x6040 0 u16 6");
  EXPECT_EQ(recorded.sent, Frames{data_frame(0x603, {0x2B, 0x40, 0x60, 0, 6, 0, 0, 0})});
  EXPECT_EQ(recorded.receive(0x583, {0x60, 0x40, 0x60, 0, 0, 0, 0, 0}), Lines{"[3] OK"});
}

TEST(AsciiGateway, AnswersAnAbortWithItsCodeAndWords) {
  RecordedGateway recorded;
  recorded.take("[4] 3 r 0x2FFF 0 u16");
  EXPECT_EQ(recorded.receive(0x583, {0x80, 0xFF, 0x2F, 0, 0x00, 0x00, 0x02, 0x06}),
            Lines{"[4] ERROR:0x06020000 #object does not exist in the object dictionary"});
}

TEST(AsciiGateway, AnswersAValueOfAnotherLengthWithAbort06070010) {
  RecordedGateway recorded;
  recorded.take("[4] 3 r 0x6041 0 u32");
  const Lines answers = recorded.receive(0x583, {0x4B, 0x41, 0x60, 0, 0x50, 0x02, 0, 0});
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_TRUE(answers[0].starts_with("[4] ERROR:0x06070010 #")) << answers[0];
}

TEST(AsciiGateway, AnswersASilentNodeWithATimeOut) {
  RecordedGateway recorded;
  recorded.take("[5] 3 r 0x6041 0 u16");
  ASSERT_EQ(recorded.gateway.next_due(), recorded.now + AsciiGateway::kSdoTimeOut);
  recorded.now += AsciiGateway::kSdoTimeOut;
  recorded.gateway.advance(recorded.now);
  EXPECT_EQ(recorded.answers, Lines{"[5] ERROR:0x05040000 #SDO protocol timed out"});
  EXPECT_EQ(recorded.gateway.next_due(), std::nullopt);
}

TEST(AsciiGateway, WaitsAsLongAsASessionSays) {
  RecordedGateway recorded;
  EXPECT_EQ(recorded.take("[1] set sdo_timeout 2000"), Lines{"[1] OK"});
  recorded.take("[2] 3 r 0x6041 0 u16");
  EXPECT_EQ(recorded.gateway.next_due(), recorded.now + std::chrono::seconds(2));
  EXPECT_EQ(recorded.take("[3] set sdo_timeout 0"), Lines{}) << "it waits for the one before";
  EXPECT_EQ(recorded.receive(0x583, {0x4B, 0x41, 0x60, 0, 0, 0, 0, 0}),
            (Lines{"[2] 0", "[3] ERROR:101 #syntax error"}));
}

TEST(AsciiGateway, SendsNmtCommands) {
  RecordedGateway recorded;
  const auto expect_sent = [&recorded](std::string_view line, std::uint8_t specifier,
                                       std::uint8_t node) {
    recorded.sent.clear();
    EXPECT_EQ(recorded.take(line), Lines{"[1] OK"}) << line;
    EXPECT_EQ(recorded.sent, Frames{data_frame(0x000, {specifier, node})}) << line;
  };
  expect_sent("[1] 3 start", 0x01, 3);
  expect_sent("[1] 3 stop", 0x02, 3);
  expect_sent("[1] 3 preop", 0x80, 3);
  expect_sent("[1] 3 reset node", 0x81, 3);
  expect_sent("[1] 3 reset comm", 0x82, 3);
  expect_sent("[1] 0 start", 0x01, 0);  // all nodes
  expect_sent("[1] 127 start", 0x01, 127);
}

TEST(AsciiGateway, TakesTheDefaultNodeWhereACommandNamesNone) {
  RecordedGateway recorded;
  EXPECT_EQ(recorded.take("[1] start"), Lines{"[1] ERROR:105 #no default node set"});
  EXPECT_EQ(recorded.take("[2] set node 9"), Lines{"[2] OK"});
  EXPECT_EQ(recorded.take("[3] start"), Lines{"[3] OK"});
  EXPECT_EQ(recorded.sent, Frames{data_frame(0x000, {1, 9})});
}

TEST(AsciiGateway, KnowsNodesFrom1To127) {
  RecordedGateway recorded;
  for (const char* const line :
       {"[1] 0 r 0x6041 0", "[1] 128 r 0x6041 0", "[1] 128 start", "[1] 18446744073709551615 start",
        "[1] set node 0", "[1] set node 128"}) {
    EXPECT_EQ(recorded.take(line), Lines{"[1] ERROR:107 #unsupported node"}) << line;
  }
  EXPECT_EQ(recorded.sent, Frames{});
}

TEST(AsciiGateway, KnowsItsOwnNetworkOnly) {
  RecordedGateway recorded(GatewaySettings{.network = 2});
  EXPECT_EQ(recorded.take("[1] 2 3 start"), Lines{"[1] OK"});
  EXPECT_EQ(recorded.take("[2] set network 2"), Lines{"[2] OK"});
  for (const char* const line :
       {"[1] 1 3 start", "[1] set network 1", "[1] 1 set node 3", "[1] 1 info version"}) {
    EXPECT_EQ(recorded.take(line), Lines{"[1] ERROR:106 #unsupported net"}) << line;
  }
}

TEST(AsciiGateway, TellsItsVersion) {
  RecordedGateway recorded(GatewaySettings{
      .vendor_id = 1, .product_code = 2, .revision_number = 0x00030004, .serial_number = 5});
  EXPECT_EQ(recorded.take("[1] info version"), Lines{"[1] 1 2 3.4 5 3 2.1 2.1"});
}

TEST(AsciiGateway, AnswersWhatItDoesNotKnowAndContinues) {
  RecordedGateway recorded;
  EXPECT_EQ(recorded.take("[1] 3 dance"), Lines{"[1] ERROR:100 #request not supported"});
  EXPECT_EQ(recorded.take("hello"), Lines{"[0] ERROR:101 #syntax error"});
  EXPECT_EQ(recorded.take(""), Lines{});
  EXPECT_EQ(recorded.take("# nothing"), Lines{});
  EXPECT_EQ(recorded.take("[2] 3 start"), Lines{"[2] OK"});
}

TEST(AsciiGateway, CarriesOutTheLinesOfASessionInTheirOrder) {
  RecordedGateway recorded;
  recorded.take("[1] 3 r 0x6041 0 u16");
  EXPECT_EQ(recorded.take("[2] 3 start"), Lines{}) << "it waits for the value";
  recorded.take("[3] 4 r 0x6041 0 u16");
  EXPECT_EQ(recorded.gateway.waiting(recorded.first), 3U);
  EXPECT_EQ(recorded.sent.size(), 1U);
  EXPECT_EQ(recorded.receive(0x583, {0x4B, 0x41, 0x60, 0, 1, 0, 0, 0}), (Lines{"[1] 1", "[2] OK"}));
  EXPECT_EQ(recorded.sent.back(), data_frame(0x604, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0}));
  EXPECT_EQ(recorded.receive(0x584, {0x4B, 0x41, 0x60, 0, 2, 0, 0, 0}), Lines{"[3] 2"});
  EXPECT_EQ(recorded.gateway.waiting(recorded.first), 0U);
}

TEST(AsciiGateway, LetsSessionsTakeTurnsOnOneNode) {
  RecordedGateway recorded;
  const GatewaySession second = recorded.gateway.open();
  recorded.take("[1] 3 r 0x6041 0 u16");
  recorded.take("[2] 3 r 0x6042 0 u16");
  recorded.gateway.take_line(second, "[1] 3 r 0x6043 0 u16", recorded.now);
  EXPECT_EQ(recorded.sent.size(), 1U) << "a node has one SDO channel";
  // The other session is next, although the first one has waited longer.
  recorded.receive(0x583, {0x4B, 0x41, 0x60, 0, 1, 0, 0, 0});
  EXPECT_EQ(recorded.sent.back(), data_frame(0x603, {0x40, 0x43, 0x60, 0, 0, 0, 0, 0}));
  recorded.receive(0x583, {0x4B, 0x43, 0x60, 0, 3, 0, 0, 0});
  EXPECT_EQ(recorded.others, Lines{"[1] 3"});
  EXPECT_EQ(recorded.receive(0x583, {0x4B, 0x42, 0x60, 0, 2, 0, 0, 0}), Lines{"[2] 2"});
}

TEST(AsciiGateway, ReadsFromSeveralNodesAtATime) {
  RecordedGateway recorded;
  const GatewaySession second = recorded.gateway.open();
  recorded.take("[1] 3 r 0x6041 0 u16");
  recorded.gateway.take_line(second, "[1] 4 r 0x6041 0 u16", recorded.now);
  EXPECT_EQ(recorded.sent.size(), 2U);
  recorded.receive(0x584, {0x4B, 0x41, 0x60, 0, 4, 0, 0, 0});
  EXPECT_EQ(recorded.others, Lines{"[1] 4"});
  EXPECT_EQ(recorded.receive(0x583, {0x4B, 0x41, 0x60, 0, 3, 0, 0, 0}), Lines{"[1] 3"});
}

TEST(AsciiGateway, AbortsTheTransferOfASessionThatIsClosed) {
  RecordedGateway recorded;
  const GatewaySession second = recorded.gateway.open();
  recorded.gateway.take_line(second, "[1] 3 r 0x6041 0 u16", recorded.now);
  recorded.gateway.take_line(second, "[2] 3 start", recorded.now);
  recorded.take("[1] 3 r 0x6042 0 u16");
  recorded.gateway.close(second, recorded.now);
  // 08000020h: data cannot be transferred to the application.
  EXPECT_EQ(recorded.sent, (Frames{data_frame(0x603, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0}),
                                   data_frame(0x603, {0x80, 0x41, 0x60, 0, 0x20, 0x00, 0x00, 0x08}),
                                   data_frame(0x603, {0x40, 0x42, 0x60, 0, 0, 0, 0, 0})}));
  EXPECT_EQ(recorded.receive(0x583, {0x4B, 0x42, 0x60, 0, 2, 0, 0, 0}), Lines{"[1] 2"});
  EXPECT_EQ(recorded.others, Lines{});
}

TEST(AsciiGateway, ForgetsASessionThatIsClosedWhileItWaitsForItsTurn) {
  RecordedGateway recorded;
  const GatewaySession second = recorded.gateway.open();
  recorded.take("[1] 3 r 0x6041 0 u16");
  recorded.gateway.take_line(second, "[1] 3 r 0x6042 0 u16", recorded.now);
  recorded.gateway.close(second, recorded.now);
  recorded.receive(0x583, {0x4B, 0x41, 0x60, 0, 1, 0, 0, 0});
  EXPECT_EQ(recorded.sent.size(), 1U);
  EXPECT_EQ(recorded.gateway.next_due(), std::nullopt);
}

TEST(AsciiGateway, ReportsBootUpsAndEmergencies) {
  RecordedGateway recorded;
  recorded.receive(0x703, {0x00});
  recorded.receive(0x083, {0x11, 0x86, 0x21, 1, 2, 3, 4, 255});
  EXPECT_EQ(recorded.reports, (Lines{"1 3 BOOT_UP", "1 3 EMCY 8611 21 1 2 3 4 255"}));
}

TEST(AsciiGateway, ReportsNoBootUpsToASessionThatDoesNotWantThem) {
  RecordedGateway recorded;
  EXPECT_EQ(recorded.take("[1] boot_up_indication Disable"), Lines{"[1] OK"});
  recorded.receive(0x703, {0x00});
  EXPECT_EQ(recorded.reports, Lines{});
  recorded.take("[2] boot_up_indication Enable");
  recorded.receive(0x703, {0x00});
  EXPECT_EQ(recorded.reports, Lines{"1 3 BOOT_UP"});
}

TEST(AsciiGateway, AwaitsNothingElse) {
  RecordedGateway recorded;
  recorded.take("[1] 3 r 0x6041 0 u16");
  for (const Frame& frame :
       {data_frame(0x703, {0x7F}), data_frame(0x080, {}),
        data_frame(0x080, {1, 2, 3, 4, 5, 6, 7, 8}), data_frame(0x183, {1, 2}),
        data_frame(0x584, {0x4B, 0x41, 0x60, 0, 1, 0, 0, 0}),
        data_frame(0x603, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0}), data_frame(0x583, {0x4B}),
        data_frame(0x700, {0}), data_frame(0x083, {1})}) {
    EXPECT_FALSE(recorded.gateway.awaits(frame)) << frame.id;
    recorded.gateway.receive(frame, recorded.now);
  }
  EXPECT_EQ(recorded.reports, Lines{});
  EXPECT_EQ(recorded.gateway.waiting(recorded.first), 1U);
}

TEST(AsciiGateway, AwaitsNothingWithoutSessions) {
  RecordedGateway recorded;
  recorded.gateway.close(recorded.first, recorded.now);
  EXPECT_FALSE(recorded.gateway.awaits(data_frame(0x703, {0x00})));
}

TEST(AsciiGateway, AnswersEachLineOfAnyTextAtMostOnce) {
  test::Random random(309);
  const std::uint64_t cases = test::case_count(500, 20'000);
  const std::vector<std::string> words{"[1]",   "1",     "3",   "0x6041", "0",   "r",   "w",
                                       "read",  "write", "u16", "vs",     "\"a", "b\"", "start",
                                       "reset", "node",  "set", "#",      "-1",  "info"};
  for (std::uint64_t i = 0; i < cases; ++i) {
    RecordedGateway recorded;
    std::string line;
    for (std::uint64_t n = random.below(9); n > 0; --n) {
      line += words[random.below(words.size())] + " ";
    }
    recorded.take(line);
    recorded.gateway.advance(recorded.now + std::chrono::hours(1));
    ASSERT_LE(recorded.answers.size(), 1U) << line;
    ASSERT_EQ(recorded.gateway.waiting(recorded.first), 0U) << line;
  }
}

}  // namespace
}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
// How bus logs are read: what each kind of line is, and that truncated, foreign and mutated lines
// are counted.
#include "log/bus_log.hpp"

#include "judge/axis_track.hpp"
#include "judge/judged_drive.hpp"
#include "judge/judged_log.hpp"
#include "judge/logged_node.hpp"
#include "node/data_sheet_reader.hpp"
#include "node/electronic_data_sheet.hpp"
#include "support/effort.hpp"
#include "support/random_cases.hpp"
#include "vdrive/cia402/controlword.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <string>
#include <vector>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

constexpr std::int8_t kPosition = 1;
constexpr std::uint32_t kMapWord = 0x60400010;
constexpr std::uint32_t kMapTarget = 0x607A0020;

std::string right_log() {
  LoggedNode node;
  node.enable(kPosition);
  node.move(10'000);
  node.move(-4'000);
  node.disable();
  return node.log();
}

TEST(BusLog, OfARightMasterHasNoFinding) {
  const LogVerdict result = judged(right_log());
  EXPECT_THAT(broken_rules(result.verdict), IsEmpty());
  EXPECT_THAT(result.verdict.axes, ElementsAre(LoggedNode::kNode));
  EXPECT_EQ(result.lines.broken, 0U);
  EXPECT_EQ(result.frames.foreign + result.frames.malformed + result.frames.unknown_mapping, 0U);
  EXPECT_GT(result.verdict.last - result.verdict.first, 200ms);
}

// A set-point by SDO: the TPDO that shows bit 12 precedes the answer to the write.
TEST(BusLog, TakesAWriteBySdoForBeforeWhatTheDriveShowsUntilItAnswers) {
  LoggedNode node;
  node.enable(kPosition);
  std::string log = node.log();
  const auto add = [&log](const std::string& time, const std::string& frame) {
    log += "(0000000009." + time + ") can0 " + frame + "\n";
  };
  add("000000", "605#237A6000E8030000");
  add("000500", "585#607A600000000000");
  add("001000", "605#2B4060001F000000");
  add("001500", "185#3712");
  add("002000", "585#6040600000000000");
  add("003000", "605#2B4060000F000000");
  add("003500", "185#3706");
  add("004000", "585#6040600000000000");
  EXPECT_THAT(rules_in(log), IsEmpty());
}

TEST(BusLog, NamesTheLineOfTheFrameThatBrokeTheRule) {
  LoggedNode node;
  node.enable(kPosition);
  node.pdo(3, {{0x000F, 2}, {1'000, 4}});
  node.step(2);
  node.word(0x001F);
  node.step(5);
  node.word(0x000F);
  node.word(0x001F);
  const auto line = static_cast<std::uint64_t>(std::ranges::count(node.log(), '\n'));
  node.step(5);
  const LogVerdict result = judged(node.log());
  ASSERT_THAT(broken_rules(result.verdict), ElementsAre("handshake-1"));
  const Finding& finding = result.verdict.findings.front();
  EXPECT_EQ(finding.first.line, line);
  EXPECT_EQ(finding.axis, LoggedNode::kNode);
  EXPECT_THAT(finding.lines, Contains(Field(&Line::place, finding.first)));
}

TEST(BusLog, LearnsTheMappingFromTheTraffic) {
  LoggedNode node;
  node.nmt(0x01);
  node.map(1, {kMapWord, kMapTarget});
  node.write(objects::kMode, kPosition, 1);
  node.step(3);
  for (const int word : {0x0006, 0x0007, 0x000F, 0x001F, 0x000F}) {
    node.pdo(1, {{word, 2}, {5'000, 4}});
    node.step(5);
  }
  node.step(300);
  node.pdo(1, {{0x001F, 2}, {0, 4}});
  node.step(5);
  const LogVerdict result = judged(node.log());
  EXPECT_THAT(broken_rules(result.verdict), IsEmpty());
  EXPECT_EQ(result.frames.unknown_mapping, 0U);
  EXPECT_THAT(result.notes, Not(Contains(HasSubstr("RPDO 1"))));
}

/// @return the log without its SDO frames.
std::string without_sdo(const std::string& log) {
  std::string rest;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    if (line.find(" 605#") == std::string::npos && line.find(" 585#") == std::string::npos) {
      rest += line + "\n";
    }
  }
  return rest;
}

/// Two edges of bit 4 without reading bit 12 between them, by a PDO with 6040h and 607Ah.
std::string remapped_log() {
  LoggedNode node;
  node.map(1, {kMapWord, kMapTarget});
  node.nmt(0x01);
  node.pdo(2, {{0, 2}, {kPosition, 1}});
  node.step(5);
  for (const int word : {0x0006, 0x0007, 0x000F, 0x001F}) {
    node.pdo(1, {{word, 2}, {5'000, 4}});
    node.step(5);
  }
  node.pdo(1, {{0x000F, 2}, {5'000, 4}});
  node.pdo(1, {{0x001F, 2}, {6'000, 4}});
  node.step(5);
  return node.log();
}

TEST(BusLog, SaysThatItDoesNotKnowAMappingInsteadOfGuessing) {
  const LogVerdict result = judged(without_sdo(remapped_log()));
  EXPECT_GT(result.frames.unknown_mapping, 0U);
  EXPECT_THAT(result.notes,
              Contains(AllOf(HasSubstr("RPDO 1 of node 5 has 6 bytes"), HasSubstr("--eds"))));
}

TEST(BusLog, TakesTheMappingOfADataSheetWhereTheLogHasNone) {
  std::string text = canopen::electronic_data_sheet({});
  const auto replace = [&text](const std::string& section, const std::string& value) {
    const std::size_t at = text.find("DefaultValue=", text.find("[" + section + "]"));
    text.replace(at, text.find('\n', at) - at, "DefaultValue=" + value);
  };
  replace("1600sub0", "2");
  replace("1600sub2", "0x607A0020");
  const canopen::DataSheet sheet = canopen::read_data_sheet(text);
  const LogVerdict result = judged(without_sdo(remapped_log()), {.sheet = &sheet});
  EXPECT_EQ(result.frames.unknown_mapping, 0U);
  EXPECT_THAT(result.notes, Not(Contains(HasSubstr("RPDO 1"))));
}

TEST(DataSheet, IsReadAsItIsWritten) {
  const canopen::DataSheet sheet = canopen::read_data_sheet(canopen::electronic_data_sheet({}));
  for (const canopen::NodeObject& object : canopen::node_objects()) {
    const auto read = sheet.find(object.address);
    ASSERT_NE(read, sheet.end()) << object.address.index;
    EXPECT_EQ(read->second.data_type, static_cast<std::uint16_t>(object.data_type));
    if (object.data_type == canopen::NodeDataType::visible_string) continue;
    EXPECT_EQ(read->second.value, object.default_value) << object.address.index;
    EXPECT_EQ(read->second.has_node_id, object.has_node_id) << object.address.index;
    EXPECT_EQ(read->second.size(), canopen::size_of(object.data_type));
  }
}

TEST(DataSheet, IsNoneWithoutASectionOfAnObject) {
  EXPECT_THROW(static_cast<void>(canopen::read_data_sheet("")), canopen::DataSheetError);
  EXPECT_THROW(static_cast<void>(canopen::read_data_sheet("[FileInfo]\nFileName=x\n")),
               canopen::DataSheetError);
  const canopen::DataSheet sheet =
      canopen::read_data_sheet("[607dSUB1]\r\nDATATYPE=0x4\r\nDefaultValue=-5\r\nParameterValue=7");
  ASSERT_TRUE(sheet.contains({0x607D, 1}));
  EXPECT_EQ(sheet.at({0x607D, 1}).value, 7) << "a DCF has what is in force";
  EXPECT_TRUE(sheet.at({0x607D, 1}).is_signed());
}

// ---- the lines of a log ------------------------------------------------------------------------

/// One frame in each format: 123h with 0011h, at 5.25 s.
struct LineCase {
  const char* text;
  LineKind kind;
  bool has_time;
};

class LogLine : public testing::TestWithParam<LineCase> {};

TEST_P(LogLine, IsWhatItsFormatSays) {
  LogLines lines;
  LoggedFrame frame;
  const LineCase& expected = GetParam();
  EXPECT_EQ(lines.read(expected.text, frame), expected.kind);
  if (expected.kind != LineKind::frame) return;
  EXPECT_EQ(frame.interface, "can0");
  EXPECT_EQ(frame.frame.id, 0x123U);
  EXPECT_EQ(frame.frame.size, 2);
  if (!frame.frame.is_remote) EXPECT_EQ(frame.frame.data[1], 0x11);
  EXPECT_EQ(frame.time.has_value(), expected.has_time);
  if (expected.has_time) EXPECT_EQ(*frame.time % 10s, 5'250ms);
}

INSTANTIATE_TEST_SUITE_P(
    Forms, LogLine,
    testing::Values(LineCase{"(0000000005.250000) can0 123#0011", LineKind::frame, true},
                    LineCase{"(1436509055.250000) can0 123#00.11", LineKind::frame, true},
                    LineCase{"(5.25) can0 123#R2", LineKind::frame, true},
                    LineCase{"(0000000005.250000) can0 123#0011 R", LineKind::frame, true},
                    LineCase{" (005.250000)  can0  123   [2]  00 11", LineKind::frame, true},
                    LineCase{" (2015-07-10 08:17:35.250000)  can0  123   [2]  00 11",
                             LineKind::frame, true},
                    LineCase{"  can0  123   [2]  00 11", LineKind::frame, false},
                    LineCase{"  can0  123   [2]  00 11   '..'", LineKind::frame, false},
                    LineCase{"  can0  RX - -  123   [2]  00 11", LineKind::frame, false},
                    LineCase{"  can0  123   [2]  remote request", LineKind::frame, false},
                    LineCase{"(5.25) can0 123##1112233", LineKind::foreign, true},
                    LineCase{"(5.25) can0 20000080#0000000000000000", LineKind::foreign, true},
                    LineCase{"  can0  123  [64]  00 11", LineKind::foreign, true},
                    LineCase{"  can0  20000080  [8]  00 00 00 00 00 00 00 00  ERRORFRAME",
                             LineKind::foreign, true},
                    LineCase{"", LineKind::nothing, false},
                    LineCase{"# a remark", LineKind::nothing, false},
                    LineCase{"(5.25) can0 123#001", LineKind::broken, false},
                    LineCase{"(5.25) can0 923#0011", LineKind::broken, false},
                    LineCase{"(5.25) can0 123#001122334455667788", LineKind::broken, false},
                    LineCase{"(5.25", LineKind::broken, false},
                    LineCase{"(-5.25) can0 123#0011", LineKind::broken, false},
                    LineCase{"(99999999999.0) can0 123#0011", LineKind::broken, false},
                    LineCase{"  can0  123   [3]  00 11", LineKind::broken, false},
                    LineCase{"  can0  123   [9]  00 11", LineKind::broken, false},
                    LineCase{"Segmentation fault", LineKind::broken, false}));

TEST(LogLine, OfAnAscHasTheBaseAndTheTimesOfItsHeader) {
  const auto frame_after = [](const char* header, const char* text) {
    LogLines lines;
    LoggedFrame frame;
    EXPECT_EQ(lines.read(header, frame), LineKind::nothing);
    EXPECT_EQ(lines.read("  // a remark", frame), LineKind::nothing);
    EXPECT_EQ(lines.read("   1.000000 1  Statistic: D 0 R 0 XD 0", frame), LineKind::foreign);
    EXPECT_EQ(lines.read(text, frame), LineKind::frame) << text;
    return frame;
  };
  const LoggedFrame hex = frame_after("base hex  timestamps absolute",
                                      "   5.250000 1  123             Rx   d 2 00 1F  Length = 1");
  EXPECT_EQ(hex.frame.id, 0x123U);
  EXPECT_EQ(hex.frame.data[1], 0x1F);
  EXPECT_EQ(hex.time, 5'250ms);
  EXPECT_EQ(hex.interface, "1");
  const LoggedFrame decimal =
      frame_after("base dec  timestamps relative", "   4.250000 2  291             Tx   d 2 00 31");
  EXPECT_EQ(decimal.frame.id, 0x123U);
  EXPECT_EQ(decimal.frame.data[1], 0x1F);
  EXPECT_TRUE(frame_after("base hex", "  5.25 1  18EBFF00x  Rx  d 1 00").frame.is_extended);
}

/// The same log as candump without -L and as .asc.
std::string as_people_format(const std::string& log) {
  std::string text;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t hash = line.find('#');
    const std::string data = line.substr(hash + 1);
    text += " " + line.substr(0, 19) + "  can0  " + line.substr(hash - 3, 3) + "   [" +
            std::to_string(data.size() / 2) + "] ";
    for (std::size_t i = 0; i < data.size(); i += 2) text += " " + data.substr(i, 2);
    text += "\n";
  }
  return text;
}

std::string as_asc(const std::string& log) {
  std::string text =
      "date Mon Nov 30 08:00:00.000 am 2026\nbase hex  timestamps absolute\n"
      "internal events logged\n";
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t hash = line.find('#');
    const std::string data = line.substr(hash + 1);
    text += "   " + line.substr(1, 17) + " 1  " + line.substr(hash - 3, 3) + "  Rx   d " +
            std::to_string(data.size() / 2);
    for (std::size_t i = 0; i < data.size(); i += 2) text += " " + data.substr(i, 2);
    text += "\n";
  }
  return text;
}

TEST(BusLog, GivesTheSameFindingsInEachFormat) {
  const std::string log = remapped_log();
  const LogVerdict expected = judged(log);
  ASSERT_THAT(expected.verdict.findings, Not(IsEmpty()));
  for (const std::string& other : {as_people_format(log), as_asc(log)}) {
    const LogVerdict result = judged(other);
    EXPECT_EQ(result.lines.broken, 0U);
    ASSERT_THAT(result.verdict.findings, SizeIs(expected.verdict.findings.size()));
    for (std::size_t i = 0; i < expected.verdict.findings.size(); ++i) {
      EXPECT_EQ(result.verdict.findings[i].rule, expected.verdict.findings[i].rule);
      EXPECT_EQ(result.verdict.findings[i].first.time, expected.verdict.findings[i].first.time);
      EXPECT_EQ(result.verdict.findings[i].happened, expected.verdict.findings[i].happened);
    }
  }
}

// ---- unusable and broken lines -----------------------------------------------------------------

TEST(BusLog, CountsWhatItCannotUseAndJudgesTheRest) {
  std::string log = right_log();
  log.insert(log.find('\n') + 1, "rubbish\n(0000000001.000200) can1 185#3706\n");
  log +=
      "(0000000099.000000) can0 1ABCDEF0#00\n"     // 29 bits
      "(0000000099.000001) can0 000#0102030405\n"  // NMT has two bytes
      "(0000000098.000000) can0 7E5#0400000000000000\n"
      "(0000000099.000002) can0 185#37";  // truncated
  const LogVerdict result = judged(log);
  EXPECT_THAT(broken_rules(result.verdict), IsEmpty());
  EXPECT_EQ(result.lines.broken, 1U);
  EXPECT_EQ(result.lines.first_broken, 2U);
  EXPECT_EQ(result.lines.other_interfaces, 1U);
  EXPECT_EQ(result.lines.backwards, 1U);
  EXPECT_EQ(result.frames.foreign, 1U);
  EXPECT_EQ(result.frames.malformed, 1U);
  EXPECT_EQ(result.frames.unknown_mapping, 1U);
  EXPECT_THAT(result.notes, Contains("1 line could not be read; the first is line 2"));
}

TEST(BusLog, JudgesOnlyTheNodesThatItIsAskedFor) {
  const std::string log = remapped_log();
  const LogVerdict other = judged(log, {.nodes = {6}});
  EXPECT_THAT(other.verdict.findings, IsEmpty());
  EXPECT_GT(other.frames.other_nodes, 10U);
  EXPECT_EQ(rules_in(log, {.nodes = {5}}), rules_in(log));
}

TEST(BusLog, LeavesADeviceAloneThatSaysItIsNoDrive) {
  const std::string type_of_io =
      "(0000000000.100000) can0 605#4000100000000000\n"
      "(0000000000.200000) can0 585#4300100091010F00\n";
  EXPECT_THAT(rules_in(type_of_io + remapped_log()), IsEmpty());
}

TEST(BusLog, IsUnreadableWithoutAFrame) {
  EXPECT_FALSE(judged("").is_readable());
  EXPECT_FALSE(judged("PK\x03\x04 this is an archive\nof something\n").is_readable());
  EXPECT_FALSE(judged(std::string(5'000, 'x')).is_readable());
  EXPECT_TRUE(judged("(5.25) can0 123#0011").is_readable());
}

TEST(BusLog, WithoutTimesJudgesWhatNeedsNone) {
  std::string log;
  std::istringstream lines(remapped_log());
  for (std::string line; std::getline(lines, line);) log += line.substr(20) + "\n";
  const LogVerdict result = judged(log);
  EXPECT_THAT(result.notes, Contains(HasSubstr("no time stamps")));
  EXPECT_THAT(broken_rules(result.verdict), Contains("handshake-1"));
  EXPECT_THAT(result.verdict.unjudged, Contains(Field(&Unjudged::fact, Fact::kTime)));
}

TEST(BusLog, SaysOnceWhatItCouldNotJudge) {
  const LogVerdict result = judged(right_log());
  std::uint32_t facts = 0;
  for (const Unjudged& unjudged : result.verdict.unjudged) {
    EXPECT_EQ(facts & unjudged.fact, 0U) << "each fact once for the same axes";
    facts |= unjudged.fact;
    EXPECT_THAT(unjudged.axes, ElementsAre(LoggedNode::kNode));
    EXPECT_THAT(missing_text(unjudged.fact), Not(IsEmpty()));
  }
  EXPECT_NE(facts & Fact::kFollowingError, 0U);
  EXPECT_EQ(facts & Fact::kStatusword, 0U);
}

// ---- correct masters on a bus ------------------------------------------------------------------

std::int32_t any_target(test::Random& random) {
  return static_cast<std::int32_t>(random.between(-20'000, 20'000));
}

/// Words by RPDO, targets by RPDO or SDO; the drive reports each change by TPDO.
void move_by_pdo(LoggedNode& node, test::Random& random) {
  node.enable(kPosition);
  for (auto moves = random.between(1, 4); moves > 0; --moves) {
    if (random.per_mille(500)) {
      node.move(any_target(random));
    } else {
      node.write(objects::kTarget, any_target(random), 4);
      node.word(0x001F | Controlword::kChangeSetImmediately);
      node.step_until_bits(0x1000, 0x1000);
      node.word(0x000F);
      node.step_until_bits(0x1000, 0);
    }
    node.step(static_cast<std::uint64_t>(random.between(0, 100)));
  }
  node.step_until_bits(0x0400, 0x0400);
  node.disable();
}

/// All by SDO, every few milliseconds; the drive reports nothing on its own.
void move_by_sdo(LoggedNode& node, test::Random& random) {
  for (std::uint16_t index = 0x1800; index <= 0x1803; ++index) {
    node.write({index, 1}, std::int64_t{0x80000000}, 4);
  }
  const auto turn = static_cast<std::uint64_t>(random.between(1, 20));
  const auto wait = [&](std::int64_t mask, std::int64_t value) {
    for (int i = 0; i < 5'000 && (node.read(objects::kStatusword) & mask) != value; ++i) {
      node.step(turn);
      if (random.per_mille(100)) node.read(objects::kPosition);
    }
  };
  const auto word = [&](std::int64_t value) {
    node.write(objects::kControlword, value, 2);
  };
  node.write(objects::kMode, kPosition, 1);
  while (node.read(objects::kModeShown) != kPosition) node.step(turn);
  word(0x0006);
  wait(0x6F, 0x21);
  word(0x0007);
  wait(0x6F, 0x23);
  word(0x000F);
  wait(0x6F, 0x27);
  for (auto moves = random.between(1, 4); moves > 0; --moves) {
    node.write(objects::kTarget, any_target(random), 4);
    word(0x001F);
    node.step();
    wait(0x1000, 0x1000);
    word(0x000F);
    node.step();
    wait(0x1000, 0);
    wait(0x0400, 0x0400);
  }
  word(0x0006);
  wait(0x6F, 0x21);
}

TEST(RightMastersOnABus, GetNoFinding) {
  const auto seeds = test::number_of<std::uint64_t>({.usual = 40, .full = 1'000, .nightly = 5'000});
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    for (const auto& move : {&move_by_pdo, &move_by_sdo}) {
      test::Random random(seed);
      LoggedNode node;
      move(node, random);
      const LogVerdict result = judged(node.log());
      EXPECT_THAT(broken_rules(result.verdict), IsEmpty()) << "seed " << seed;
      EXPECT_GT(result.verdict.records, 20U);
    }
  }
}

// ---- SDO transfers -----------------------------------------------------------------------------

canopen::Frame sdo(std::array<std::uint8_t, 8> data) {
  return {.size = 8, .data = data};
}

TEST(SdoObserver, PutsTheSegmentsOfAnUploadTogether) {
  SdoObserver observer;
  EXPECT_FALSE(observer.take_request(sdo({0x40, 0x08, 0x10, 0x00})));
  EXPECT_FALSE(observer.take_response(sdo({0x41, 0x08, 0x10, 0x00, 0x09})));
  EXPECT_FALSE(observer.take_request(sdo({0x60})));
  EXPECT_FALSE(observer.take_response(sdo({0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'})));
  EXPECT_FALSE(observer.take_request(sdo({0x70})));
  const auto transfer = observer.take_response(sdo({0x1B, 'h', 'i'}));
  ASSERT_TRUE(transfer);
  EXPECT_FALSE(transfer->is_download);
  EXPECT_EQ(transfer->object, (ObjectAddress{0x1008, 0}));
  EXPECT_EQ(std::string(transfer->data.begin(), transfer->data.end()), "abcdefghi");
}

TEST(SdoObserver, HasTheDataOfASegmentedDownloadBeforeItsLastAnswer) {
  SdoObserver observer;
  EXPECT_FALSE(observer.take_request(sdo({0x21, 0x40, 0x60, 0x00, 0x02})));
  EXPECT_FALSE(observer.take_response(sdo({0x60, 0x40, 0x60, 0x00})));
  EXPECT_EQ(observer.pending_download(), nullptr);
  EXPECT_FALSE(observer.take_request(sdo({0x0B, 0x1F, 0x00})));
  ASSERT_NE(observer.pending_download(), nullptr);
  EXPECT_THAT(observer.pending_download()->data, ElementsAre(0x1F, 0x00));
  const auto transfer = observer.take_response(sdo({0x20}));
  ASSERT_TRUE(transfer);
  EXPECT_EQ(transfer->abort, 0U);
}

TEST(SdoObserver, TellsWhyATransferWasAborted) {
  SdoObserver observer;
  EXPECT_FALSE(observer.take_request(sdo({0x2B, 0x40, 0x60, 0x00, 0x1F})));
  EXPECT_FALSE(observer.take_response(sdo({0x80, 0x41, 0x60, 0x00, 0x22, 0x00, 0x00, 0x08})))
      << "of another object";
  const auto transfer =
      observer.take_response(sdo({0x80, 0x40, 0x60, 0x00, 0x22, 0x00, 0x00, 0x08}));
  ASSERT_TRUE(transfer);
  EXPECT_EQ(transfer->abort, 0x08000022U);
}

TEST(SdoObserver, TakesNoSegmentOfABlockForACommand) {
  SdoObserver observer;
  EXPECT_FALSE(observer.take_request(sdo({0xC2, 0x00, 0x20, 0x00, 0x0A})));
  EXPECT_FALSE(observer.take_response(sdo({0xA0, 0x00, 0x20, 0x00, 0x7F})));
  // Sequence numbers 21h and 22h look like initiate requests.
  EXPECT_FALSE(observer.take_request(sdo({0x21, 0x40, 0x60, 0x00, 0x0F})));
  EXPECT_FALSE(observer.take_request(sdo({0x22, 0x40, 0x60, 0x00, 0x0F})));
  EXPECT_FALSE(observer.take_request(sdo({0xA3, 0x40, 0x60, 0x00, 0x0F})));
  EXPECT_EQ(observer.pending_download(), nullptr);
  EXPECT_FALSE(observer.take_response(sdo({0xA2, 0x23, 0x7F})));
  EXPECT_FALSE(observer.take_request(sdo({0xD5})));
  const auto transfer = observer.take_response(sdo({0xA1}));
  ASSERT_TRUE(transfer);
  EXPECT_FALSE(transfer->is_complete);
  EXPECT_EQ(transfer->object, (ObjectAddress{0x2000, 0}));
}

TEST(SdoObserver, SeesThatTheNodeAbortsADownloadByBlocks) {
  SdoObserver observer;
  EXPECT_FALSE(observer.take_request(sdo({0xC2, 0x00, 0x20, 0x00, 0x0A})));
  EXPECT_FALSE(observer.take_response(sdo({0xA0, 0x00, 0x20, 0x00, 0x7F})));
  EXPECT_FALSE(observer.take_request(sdo({0x01})));
  const auto transfer =
      observer.take_response(sdo({0x80, 0x00, 0x20, 0x00, 0x04, 0x00, 0x04, 0x05}));
  ASSERT_TRUE(transfer);
  EXPECT_EQ(transfer->abort, 0x05040004U);
  // The next request is a command again, not a segment.
  EXPECT_FALSE(observer.take_request(sdo({0x2B, 0x40, 0x60, 0x00, 0x1F})));
  EXPECT_NE(observer.pending_download(), nullptr);
}

TEST(SdoObserver, SeesThatTheNodeAbortsAnUploadByBlocks) {
  SdoObserver observer;
  EXPECT_FALSE(observer.take_request(sdo({0xA0, 0x08, 0x10, 0x00, 0x7F})));
  EXPECT_FALSE(observer.take_response(sdo({0xC2, 0x08, 0x10, 0x00, 0x0E})));
  EXPECT_FALSE(observer.take_request(sdo({0xA3})));
  EXPECT_FALSE(observer.take_response(sdo({0x01, 'v', 'd', 'r', 'i', 'v', 'e', ' '})));
  const auto transfer =
      observer.take_response(sdo({0x80, 0x08, 0x10, 0x00, 0x04, 0x00, 0x04, 0x05}));
  ASSERT_TRUE(transfer);
  EXPECT_EQ(transfer->abort, 0x05040004U);
}

// ---- mutated logs ------------------------------------------------------------------------------

std::string mutated(std::string log, test::Random& random) {
  const auto place = [&] {
    return static_cast<std::size_t>(random.below(log.size()));
  };
  const auto times = static_cast<int>(random.between(1, 30));
  for (int i = 0; i < times && !log.empty(); ++i) {
    switch (random.below(6)) {
      case 0:
        log[place()] = static_cast<char>(random.below(256));
        break;
      case 1:
        log.erase(place(), static_cast<std::size_t>(random.below(80)));
        break;
      case 2:
        log.insert(place(), log.substr(place(), static_cast<std::size_t>(random.below(200))));
        break;
      case 3:
        log.insert(place(), std::string(static_cast<std::size_t>(random.below(3'000)), '#'));
        break;
      case 4: {
        const std::size_t at = place();
        if (std::isxdigit(static_cast<unsigned char>(log[at])) != 0)
          log[at] = "0123456789ABCDEF"[random.below(16)];
        break;
      }
      default:
        log.resize(place());
    }
  }
  return log;
}

TEST(BusLog, IsJudgedHoweverItIsMutated) {
  const std::array<std::string, 3> logs{right_log(), as_people_format(remapped_log()),
                                        as_asc(remapped_log())};
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    test::Random random(seed);
    const std::string log = mutated(logs.at(random.below(logs.size())), random);
    const LogVerdict result = judged(log);
    const auto ends = static_cast<std::uint64_t>(std::ranges::count(log, '\n'));
    EXPECT_GE(result.lines.lines, ends) << "seed " << seed;
    EXPECT_LE(result.lines.lines, ends + 1) << "seed " << seed;
    EXPECT_LE(result.lines.broken + result.lines.foreign + result.frames.frames +
                  result.lines.other_interfaces,
              result.lines.lines)
        << "seed " << seed;
  }
}

}  // namespace
}  // namespace vdrive::judge

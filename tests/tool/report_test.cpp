// SPDX-License-Identifier: Apache-2.0
// The output of the tool: JSON fields (docs/reference/json.md), text, the dictionary.
#include "output/report.hpp"

#include "base/usage_error.hpp"
#include "commands/dictionary.hpp"
#include "execution/command_progress.hpp"
#include "output/event_view.hpp"
#include "output/live_view.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace vdrive::tool {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;
using testing::StartsWith;

client::AxisSnapshot moving_axis() {
  client::AxisSnapshot axis;
  axis.id = {1, 2};
  axis.tick = 42;
  axis.owner_session = 0x0123456789abcdef;
  axis.status.ds402_statusword = 0x1237;
  axis.status.op_mode_actual = 1;
  axis.status.load_position_actual_value = -500;
  axis.status.load_velocity_actual_value = 1000;
  return axis;
}

const client::SessionName kVdrive{.program = "vdrive", .process = 4711, .host = "bench-host"};

std::vector<std::string> keys(const Json& json) {
  std::vector<std::string> names;
  for (const auto& [key, value] : json.items()) names.push_back(key);
  return names;
}

TEST(EventText, NamesTheProgramsOfTheSessionsThatAreKnown) {
  const SessionNameOf name_of = [](std::uint32_t /*bench*/, std::uint64_t session) {
    return session == 10 ? std::optional(kVdrive) : std::nullopt;
  };
  client::Event event;
  event.bench = 1;
  event.axis = 2;
  event.tick = 42;
  event.kind = client::EventKind::stopped;
  event.text =
      "axis 2: quick stop by session 0x000000000000000a; session 0x000000000000000b keeps control";
  EXPECT_EQ(event_text(event, name_of),
            "42  1.2  quick stop by vdrive (process 4711 on bench-host), session "
            "0x000000000000000a; session 0x000000000000000b keeps control");
  event.text = "axis 2: released by session 0x00000000";  // cut off
  EXPECT_EQ(event_text(event, name_of), "42  1.2  released by session 0x00000000");
}

TEST(StatusJson, HasStateFlagsAndEveryMonitoredObject) {
  const Json json = recording::status_json(moving_axis(), "y", std::nullopt);
  EXPECT_EQ(json["axis"], "1.2");
  EXPECT_EQ(json["name"], "y");
  EXPECT_EQ(json["tick"], 42);
  EXPECT_EQ(json["state"], "Operation enabled");
  EXPECT_EQ(json["flags"], (Json{"voltage enabled", "remote", "set-point acknowledge"}));
  EXPECT_EQ(json["ds402_statusword"], 0x1237);
  EXPECT_EQ(json["load_position_actual_value"], -500);
  EXPECT_EQ(json["owner"], "0x0123456789abcdef");
  for (const ObjectDescription& row : kObjectTable) {
    if (row.origin != Origin::manual || row.access != Access::read_only) continue;
    EXPECT_TRUE(json.contains(std::string(row.variable_name))) << row.variable_name;
  }
}

TEST(StatusJson, OfAFreeAxisHasNoOwner) {
  client::AxisSnapshot axis = moving_axis();
  axis.owner_session = 0;
  EXPECT_TRUE(recording::status_json(axis, "y", std::nullopt)["owner"].is_null());
}

TEST(StatusText, DecodesTheStatusword) {
  const std::vector<std::string> lines = status_text(moving_axis(), {"y", {}});
  EXPECT_EQ(lines[0], "1.2 y");
  EXPECT_THAT(lines[1], HasSubstr("0x1237 Operation enabled: voltage enabled, remote, set-point "
                                  "acknowledge"));
  EXPECT_THAT(lines[2], HasSubstr("1 profile position"));
}

TEST(StatusJson, OfAnAxisWithAUnitHasPositionAndVelocityInIt) {
  const client::Unit mm{.kind = client::UnitKind::linear, .name = "mm", .size = 1'000.0};
  const Json json = status_json(moving_axis(), AxisLabel{"y", mm});
  EXPECT_EQ(json["load_position_actual_value"], -500);
  EXPECT_EQ(json["unit"], "mm");
  EXPECT_EQ(json["position_in_unit"], -0.5);
  EXPECT_EQ(json["velocity_in_unit"], 1.0);
}

TEST(StatusText, ShowsUserUnitsAndTheUnitOfTheAxis) {
  const client::Unit mm{.kind = client::UnitKind::linear, .name = "mm", .size = 1'000.0};
  const std::vector<std::string> lines = status_text(moving_axis(), {"y", mm});
  EXPECT_EQ(lines[3], "  position    -500 UU, demand 0, error 0");
  EXPECT_EQ(lines[4], "              -0.500 mm, demand 0.000 mm, error 0.000 mm");
  EXPECT_EQ(lines[5], "  velocity    1000 UU/s, demand 0");
  EXPECT_EQ(lines[6], "              1.000 mm/s, demand 0.000 mm/s");
}

TEST(StatusText, NamesTheError) {
  client::AxisSnapshot axis = moving_axis();
  axis.status.ds402_statusword = 0x2218;
  axis.status.error_code = 0x8611;
  std::string text;
  for (const std::string& line : status_text(axis, {"y", {}})) text += line + "\n";
  EXPECT_THAT(text, HasSubstr("0x2218 Fault"));
  EXPECT_THAT(text, HasSubstr("0x8611 "));
}

TEST(StateText, HasStateThenErrorThenBits) {
  client::AxisSnapshot axis = moving_axis();
  EXPECT_EQ(state_text(axis), "Operation enabled: set-point acknowledge");
  EXPECT_EQ(color_of(axis), std::nullopt);
  axis.status.ds402_statusword = 0x0218;
  axis.status.error_code = 0x8611;
  EXPECT_EQ(state_text(axis), "Fault 0x8611 following error");
  EXPECT_EQ(color_of(axis), Color::red);
  axis.status = {};
  axis.status.ds402_statusword = 0x0AB7;  // bits 7 and 11 in addition to those of 0x0237
  EXPECT_EQ(state_text(axis), "Operation enabled: warning, internal limit active");
  EXPECT_EQ(color_of(axis), Color::yellow);
}

TEST(ListJson, HasBenchAxisStateAndOwner) {
  client::BenchInfo bench;
  bench.number = 1;
  client::AxisInfo info;
  info.id = {1, 2};
  const Json unnamed = record_json(list_record(bench, info, moving_axis(), std::nullopt));
  EXPECT_THAT(keys(unnamed),
              ElementsAre("axis", "bench", "bench_name", "clock", "period_us", "host", "version",
                          "name", "state", "statusword", "owner", "owner_name", "tick"));
  EXPECT_TRUE(unnamed["owner_name"].is_null());
  EXPECT_EQ(record_json(list_record(bench, info, moving_axis(), kVdrive))["owner_name"],
            (Json{{"program", "vdrive"}, {"process", 4711}, {"host", "bench-host"}}));
}

TEST(OwnerText, NamesTheProgramOfTheSession) {
  constexpr const char* kOwner = "vdrive (process 4711 on bench-host), session 0x0123456789abcdef";
  EXPECT_THAT(status_text(moving_axis(), {.name = "y", .unit = {}, .owner = kVdrive}),
              Contains("  owner       " + std::string(kOwner)));
  EXPECT_THAT(record_text(list_record({}, {}, moving_axis(), kVdrive)), HasSubstr(kOwner));
  EXPECT_THAT(record_text(list_record({}, {}, moving_axis(), std::nullopt)),
              HasSubstr("0x0123456789abcdef"));
}

TEST(OutcomeJson, OfARefusalHasTheSessionThatStandsInTheWay) {
  Record record;
  add_outcome(record, client::Outcome::refused(0x08000021, "control of axis 1.1 refused",
                                               {.axis = {1, 1}, .session = 0x0B, .name = kVdrive}));
  const Json json = record_json(record);
  EXPECT_THAT(keys(json), ElementsAre("outcome", "code", "message", "owner", "owner_name"));
  EXPECT_EQ(json["message"],
            "control of axis 1.1 refused: axis 1.1 is controlled by vdrive (process 4711 on "
            "bench-host), session 0x000000000000000b");
  EXPECT_EQ(json["owner"], "0x000000000000000b");
  EXPECT_EQ(json["owner_name"]["process"], 4711);
}

TEST(ObjectJson, HasAxisAddressAndName) {
  Record record = object_fields({1, 1}, parse_object("ds402_statusword"));
  record.push_back({"value", 592});
  EXPECT_EQ(
      to_line(record_json(record)),
      R"({"axis":"1.1","index":"0x6041","subindex":0,"name":"ds402_statusword","value":592})");
}

TEST(ObjectJson, OfAnUnknownObjectHasNoName) {
  EXPECT_TRUE(record_json(object_fields({1, 1}, parse_object("0x9999")))["name"].is_null());
  const Json unknown = record_json(object_fields({1, 1}, parse_object("no_such")));
  EXPECT_EQ(unknown["name"], "no_such");
  EXPECT_TRUE(unknown["index"].is_null());
}

TEST(OutcomeJson, HasCodeAndMessageOfAFailureOnly) {
  Record good;
  add_outcome(good, client::Outcome());
  EXPECT_EQ(to_line(record_json(good)), R"({"outcome":"ok"})");
  Record refused;
  add_outcome(refused, client::Outcome::refused(0x06010002, "write"));
  const Json bad = record_json(refused);
  EXPECT_EQ(bad["outcome"], "refused");
  EXPECT_EQ(bad["code"], "0x06010002");
  EXPECT_THAT(bad["message"].get<std::string>(), StartsWith("write: 0x06010002"));
}

TEST(Record, HasTheTextsOfItsFieldsInOneLineAndALastValueOfEachName) {
  const Record record{{"bench", 1, "bench 1"}, {"ticks", 3}, {"tick", 4, "tick 4"}, {"ticks", 5}};
  EXPECT_EQ(record_text(record), "bench 1 tick 4");
  EXPECT_EQ(to_line(record_json(record)), R"({"bench":1,"ticks":5,"tick":4})");
}

TEST(Line, OfTextThatIsNotUtf8StaysOneLine) {
  EXPECT_THAT(to_line(Json{{"name", "\xFF\n"}}), Not(HasSubstr("\n")));
}

TEST(Dictionary, HasARowForEachObjectInEachFormat) {
  for (const Language language : {Language::en, Language::zh}) {
    EXPECT_THAT(dictionary_lines({TableFormat::table, language}), SizeIs(kObjectTable.size() + 1));
    EXPECT_THAT(dictionary_lines({TableFormat::csv, language}), SizeIs(kObjectTable.size() + 1));
    EXPECT_THAT(dictionary_lines({TableFormat::json, language}), SizeIs(kObjectTable.size()));
  }
}

TEST(Dictionary, TableHasTheColumnsThatTheGuideNames) {
  const auto lines = dictionary_lines({TableFormat::table, Language::en});
  EXPECT_THAT(lines[0], testing::ContainsRegex("access +stored +default +range +units$"));
  const auto velocity = std::ranges::find_if(lines, [](const std::string& line) {
    return line.starts_with("0x6081");
  });
  ASSERT_NE(velocity, lines.end());
  EXPECT_THAT(*velocity, testing::ContainsRegex("RW +yes +68267 +0 .. 4294967295 +VelUU$"));
}

TEST(Dictionary, ShowsTheNamedObjects) {
  EXPECT_THAT(dictionary_lines({TableFormat::json, Language::en, {parse_object("0x607D")}}),
              SizeIs(2));
  EXPECT_THAT(dictionary_lines({TableFormat::table,
                                Language::en,
                                {parse_object("statusword"), parse_object("0x607D:1")}}),
              SizeIs(3));
}

TEST(ArrivalLine, HasTheTypedNameAndNoSpeed) {
  client::AxisSnapshot axis = moving_axis();
  axis.status.ds402_statusword = 0x0637;
  axis.status.load_velocity_actual_value = 15;
  // -500 of 4096 UU are -43.945 of 360 deg.
  EXPECT_EQ(arrival_line(axis, "gantry_left", {}),
            "gantry_left       -500 UU   -43.95 deg  0x637 Operation enabled: target reached");
  EXPECT_EQ(status_line(axis, "1.2", {}),
            "1.2        -500 UU   -43.95 deg       15 UU/s     1.32 deg/s  0x637 Operation "
            "enabled: target reached");
}

TEST(Dictionary, OfANodeHasCommunicationObjectsNextToTheRows) {
  std::size_t of_the_drive = 0;
  Json controlword;
  Json device_name;
  const auto lines = dictionary_lines({TableFormat::node_json, Language::en});
  for (const std::string& line : lines) {
    const Json row = Json::parse(line);
    EXPECT_THAT(keys(row), ElementsAre("index", "subindex", "name", "index_name", "object_type",
                                       "type", "access", "owner", "pdo_mapping", "lower_limit",
                                       "upper_limit", "default", "adds_node_id"));
    of_the_drive += row["owner"] == "drive" ? 1U : 0U;
    if (row["index"] == "0x6040") controlword = row;
    if (row["index"] == "0x1008") device_name = row;
  }
  EXPECT_EQ(of_the_drive, kObjectTable.size());
  EXPECT_GT(lines.size(), kObjectTable.size());
  EXPECT_EQ(to_line(controlword),
            R"({"index":"0x6040","subindex":0,"name":"DS402 Controlword",)"
            R"("index_name":"DS402 Controlword","object_type":"variable","type":"UNSIGNED16",)"
            R"("access":"rw","owner":"drive","pdo_mapping":"both","lower_limit":0,)"
            R"("upper_limit":65535,"default":0,"adds_node_id":false})");
  EXPECT_TRUE(device_name["upper_limit"].is_null());
  EXPECT_EQ(device_name["default"], "vdrive");
}

TEST(Dictionary, OfANodeIsAnElectronicDataSheet) {
  const auto lines = dictionary_lines({TableFormat::eds, Language::en});
  EXPECT_EQ(lines.front(), "[FileInfo]");
  for (const char* const line : {"[MandatoryObjects]", "[607Dsub1]", "NrOfRXPDO=4"}) {
    EXPECT_THAT(lines, testing::Contains(line));
  }
}

/// @return the DefaultValue in a section of an electronic data sheet.
std::string default_in(const std::vector<std::string>& lines, const std::string& section) {
  constexpr std::string_view kKey = "DefaultValue=";
  auto line = std::ranges::find(lines, "[" + section + "]");
  while (line != lines.end() && !line->starts_with(kKey)) ++line;
  return line == lines.end() ? "" : line->substr(kKey.size());
}

// Axis 2 of bench 1 has serial number 65538, 0x10002.
TEST(Dictionary, OfOneNodeHasTheValuesOfItsAxisAfterPowerUp) {
  const auto lines = dictionary_lines({.format = TableFormat::eds, .node = 12, .axis_number = 2});
  EXPECT_EQ(default_in(lines, "1018sub4"), "0x00010002");
  EXPECT_EQ(default_in(lines, "1800sub1"), "0x0000018C");
  EXPECT_EQ(default_in(lines, "6041"), "592") << "0250h, switch on disabled";
  for (const std::string& line : lines) EXPECT_EQ(line.find('$'), std::string::npos) << line;
}

TEST(Dictionary, OfANodeSaysWhyThereIsNoSuchAxis) {
  const auto refusal_of_sheet = [](const DictionaryCommand& command) {
    try {
      return dictionary_lines(command).front();
    } catch (const UsageError& error) {
      return std::string(error.what());
    }
  };
  EXPECT_THAT(refusal_of_sheet({.format = TableFormat::eds, .node = 1, .preset = "widner"}),
              testing::HasSubstr("winder"));
  EXPECT_THAT(refusal_of_sheet(
                  {.format = TableFormat::eds, .node = 1, .configuration = "no-such-file.yaml"}),
              testing::HasSubstr("no-such-file.yaml"));
}

TEST(Dictionary, JsonHasEveryColumnOfTheRow) {
  const Json row = Json::parse(dictionary_lines({TableFormat::json, Language::zh})[0]);
  EXPECT_THAT(keys(row), ElementsAre("index", "subindex", "name", "title", "category", "type",
                                     "access", "stored", "effective", "lower_limit", "upper_limit",
                                     "default", "units", "origin"));
  EXPECT_EQ(row["index"], "0x1000");
  EXPECT_EQ(row["title"], "设备类型");
}

// 1097 UU at 13 UU/s take 84.4 s.
TEST(MotionText, HasPlaceSpeedAndTheTimeThatIsLeft) {
  client::AxisSnapshot axis = moving_axis();
  axis.status.position_demand_value = 1'097;
  axis.status.velocity_demand_value = -13;
  EXPECT_EQ(motion_text(axis, "lift", {}, 0),
            "axis lift: at 96.42 deg, target 0.00 deg, -1.14 deg/s, about 85 s left");
  EXPECT_EQ(motion_text(axis, "lift", {}, 2'000),
            "axis lift: at 96.42 deg, target 175.78 deg, -1.14 deg/s")
      << "it leads away from the target";
  EXPECT_EQ(motion_text(axis, "lift", {}, std::nullopt),
            "axis lift: moving, at 96.42 deg, -1.14 deg/s, Operation enabled");
  axis.status.velocity_demand_value = 0;
  EXPECT_EQ(motion_text(axis, "1.2", {}, 0), "axis 1.2: at 96.42 deg, target 0.00 deg, 0.00 deg/s");
}

TEST(CountText, HasTheAxesThatAreDone) {
  EXPECT_EQ(count_text("enable", 412, 10'000), "enable: 412 of 10000 axes");
}

TEST(ProgressBar, StaysWithinItsEnds) {
  EXPECT_EQ(progress_bar(0.5, 4), "[##--]");
  EXPECT_EQ(progress_bar(-1.0, 4), "[----]");
  EXPECT_EQ(progress_bar(7.0, 4), "[####]");
}

}  // namespace
}  // namespace vdrive::tool

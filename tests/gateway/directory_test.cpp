// SPDX-License-Identifier: Apache-2.0
#include "directory.hpp"

#include "descriptions.hpp"
#include "parameter_desk.hpp"
#include "services.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive_messages_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

namespace vdrive::gateway {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

KnownBench bench_of(const std::vector<std::string>& names) {
  client::BenchInfo info;
  info.number = 3;
  for (const std::string& name : names) {
    info.axes.push_back(
        {.id = {3, static_cast<std::uint16_t>(info.axes.size() + 1)}, .name = name, .unit = {}});
  }
  return known_bench(std::move(info));
}

TEST(Names, HaveLettersDigitsAndUnderlinesAndAreUnique) {
  const KnownBench bench = bench_of({"x", "x-y", "x/y", "x y", ""});
  EXPECT_EQ(bench.topic, "bench3");
  EXPECT_THAT(bench.axis_names, ElementsAre("x", "x_y", "x_y_3", "x_y_4", "axis5"));
}

TEST(Parameters, AreFoundByTheirListedNames) {
  const std::vector<KnownBench> benches{bench_of({"x", "y"})};
  const auto names = all_parameters(benches);
  EXPECT_EQ(names.size(), 2 * kObjectTable.size());
  for (const std::string& name : names) EXPECT_TRUE(find_parameter(benches, name)) << name;
  for (const char* object : {"0x607D:01", "0x607D:1", "607Dh:1"}) {
    const auto found = find_parameter(benches, std::string("bench3/y/") + object);
    ASSERT_TRUE(found) << object;
    EXPECT_EQ(found->axis, (client::AxisId{3, 2}));
    EXPECT_EQ(found->object, (ObjectAddress{0x607D, 1}));
  }
}

TEST(Parameters, AreNotFoundByOtherNames) {
  const std::vector<KnownBench> benches{bench_of({"x"})};
  for (const char* name :
       {"", "/", "bench3/x", "bench3/x/6081", "bench3/x/0x", "bench3/x/0x6081:", "bench3/x/0xFFFF",
        "bench3/z/0x6081", "bench4/x/0x6081", "bench3/x/0x6081/", "bench3/x/0x607D:100"}) {
    EXPECT_FALSE(find_parameter(benches, name)) << name;
  }
}

TEST(Parameters, AreNotListedAboveTheLimitOfAxes) {
  std::vector<std::string> names(kMostAxesOfAll + 1, "a");
  EXPECT_TRUE(all_parameters({bench_of(names)}).empty());
  names.pop_back();
  EXPECT_EQ(all_parameters({bench_of(names)}).size(), kMostAxesOfAll * kObjectTable.size());
}

TEST(Dictionary, HasEveryObjectAndTheNamesOfBits) {
  const Json dictionary = Json::parse(dictionary_text());
  EXPECT_EQ(dictionary["objects"].size(), kObjectTable.size());
  EXPECT_EQ(dictionary["modes"].size(), 10U);        // 0 to 4, 6 to 10
  EXPECT_EQ(dictionary["error_codes"].size(), 10U);  // 9 errors and none
  for (const Json& row : dictionary["modes"]) {
    EXPECT_EQ(row["commands_torque"], row["mode"] == 4 || row["mode"] == 10) << row["mode"];
  }
  const auto bits = [&](const char* word, int mode) {
    for (const Json& row : dictionary[word]) {
      if (row["mode"] == mode) return row["bits"];
    }
    return Json();
  };
  EXPECT_EQ(bits("statusword_bits", 1)[12], "set-point acknowledge");
  EXPECT_EQ(bits("statusword_bits", 6)[12], "homing attained");
  EXPECT_EQ(bits("statusword_bits", 6)[13], "homing error");
  EXPECT_EQ(bits("statusword_bits", 1)[3], "fault");
  EXPECT_EQ(bits("statusword_bits", 1)[10], "target reached");
  EXPECT_EQ(bits("controlword_bits", 1)[4], "new set-point");
  EXPECT_EQ(bits("controlword_bits", 6)[4], "start homing");
  EXPECT_EQ(bits("controlword_bits", 3)[4], "");
  // CiA 402-2: velocity mode (vl) and interpolated position mode (ip).
  EXPECT_EQ(bits("controlword_bits", 2)[4], "enable ramp");
  EXPECT_EQ(bits("controlword_bits", 2)[5], "unlock ramp");
  EXPECT_EQ(bits("controlword_bits", 2)[6], "reference ramp");
  EXPECT_EQ(bits("controlword_bits", 7)[4], "enable interpolation");
  EXPECT_EQ(bits("statusword_bits", 7)[12], "interpolation active");
  for (const int cyclic : {8, 9, 10}) {
    EXPECT_EQ(bits("statusword_bits", cyclic)[12], "follows command") << cyclic;
    EXPECT_EQ(bits("controlword_bits", cyclic)[4], "") << cyclic;
  }
  EXPECT_EQ(dictionary["disturbances"][0]["kind"], "value");
  EXPECT_EQ(dictionary["disturbances"][1]["kind"], "switch");
  const auto homing_method = [&](int number) {
    for (const Json& row : dictionary["homing_methods"]) {
      if (row["method"] == number) return row;
    }
    return Json();
  };
  EXPECT_EQ(homing_method(17), Json({{"method", 17},
                                     {"direction", -1},
                                     {"limit_switch", true},
                                     {"home_switch", false},
                                     {"hard_stop", false},
                                     {"index_pulse", false}}));
  EXPECT_EQ(homing_method(7)["home_switch"], true);
  EXPECT_EQ(homing_method(-2)["hard_stop"], true);
}

TEST(Schemas, ReadMembersTheirTypesListsAndThoseThatMayBeLeftOut) {
  EXPECT_EQ(object_schema("n:string axes:axis[] k?:number", {{"axis", {{"type", "x"}}}}),
            Json::parse(R"({"type": "object", "required": ["n", "axes"],
                            "properties": {"n": {"type": "string"}, "k": {"type": "number"},
                                           "axes": {"type": "array", "items": {"type": "x"}}}})"));
  EXPECT_EQ(object_schema("")["required"], Json::array());
}

/// @return the names that are in the schema but not in the message, or vice versa.
std::set<std::string> differences(const Json& schema, const Json& message) {
  std::set<std::string> names;
  for (const auto& [name, type] : schema["properties"].items()) {
    if (!message.contains(name)) names.insert(name);
    // The first element of a list represents all.
    if (type["type"] == "array" && type["items"].contains("properties")) {
      names.merge(differences(type["items"], message[name].at(0)));
    }
  }
  for (const auto& [name, value] : message.items()) {
    if (!schema["properties"].contains(name)) names.insert(name);
  }
  return names;
}

TEST(Schemas, HaveEachMemberOfTheirMessagesAndNoOther) {
  const KnownBench bench = bench_of({"x"});
  const auto differ = [](const ChannelInfo& channel, const std::string& message) {
    return differences(Json::parse(channel.schema), Json::parse(message));
  };
  EXPECT_THAT(differ(description_channel(""), description_text(bench)), IsEmpty());
  EXPECT_THAT(
      differ(state_channel(""), state_text(bench.info, 1, {}, true, {{0x0B, {.program = "vdrive"}}},
                                           {{.axis = 1, .from = 0x0A, .by = 0x0B, .tick = 1}})),
      IsEmpty());
  EXPECT_THAT(differ(control_channel(), control_text({}, "client 1", false)), IsEmpty());
  EXPECT_THAT(differ(dictionary_channel(), dictionary_text()), IsEmpty());
}

TEST(StateOfABench, HasTheFiguresThatAreHeadlines) {
  KnownBench bench = bench_of({"x"});
  for (client::Figure& figure : bench.info.figures) figure.value = figure.name.size();
  const Json state = Json::parse(state_text(bench.info, 1, {}, true));
  wire::for_each_figure<msg::BenchState>([&](const wire::MemberTraits& figure) {
    const std::string name(figure.name);
    ASSERT_EQ(state.contains(name), figure.is_headline) << name;
    if (figure.is_headline) EXPECT_EQ(state[name], name.size()) << name;
  });
  EXPECT_TRUE(state.contains("wire_starts"));
  EXPECT_TRUE(state.contains("longest_silence_us"));
}

TEST(Services, HaveNamesTypesAndSchemas) {
  std::set<std::string> names;
  for (const ServiceInfo& service : service_infos()) {
    EXPECT_TRUE(names.insert(service.name).second) << service.name;
    EXPECT_TRUE(service.type.starts_with("vdrive.")) << service.name;
    EXPECT_EQ(service.request_schema["type"], "object") << service.name;
    EXPECT_EQ(service.response_schema["required"], Json({"ok", "outcome", "message", "code"}));
  }
  EXPECT_EQ(names.size(), 27U);
}

TEST(Services, AnswerWithTheOutcomesOfTheClientLibrary) {
  const Json answer = Json::parse(answer_text(
      {.outcome = client::Outcome::refused(0x08000022, "no"), .fields = {{"tick", 5}}}));
  EXPECT_EQ(answer["ok"], false);
  EXPECT_EQ(answer["outcome"], "refused");
  EXPECT_EQ(answer["code"], 0x08000022);
  EXPECT_EQ(answer["tick"], 5);
}

}  // namespace
}  // namespace vdrive::gateway

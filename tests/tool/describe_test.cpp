// SPDX-License-Identifier: Apache-2.0
// `vdrive describe`: everything about one axis.
#include "support/bench_on_wire.hpp"
#include "tool/call.hpp"
#include "tool/json_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

class Describe : public testing::Test {
 protected:
  static Json description_of(const std::string& axis) {
    const Finished finished = call("describe " + axis + " --json");
    EXPECT_EQ(finished.code, 0) << finished.errors;
    const std::vector<Json> objects = json_of(finished);
    EXPECT_THAT(objects, SizeIs(1));
    return objects.empty() ? Json() : objects.front();
  }

  /// @return the objects with this name in the description.
  static std::vector<Json> objects_called(const Json& description, const std::string& name) {
    std::vector<Json> found;
    std::ranges::copy_if(description["objects"], std::back_inserter(found),
                         [&](const Json& object) {
                           return object["name"] == name;
                         });
    return found;
  }

  BenchOnWire bench_{"--clock lockstep"};
};

TEST_F(Describe, ShowsBenchOwnerStateFaultAndModelOfAnAxis) {
  const Finished finished = call("describe 1.1");
  ASSERT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.lines().front(), HasSubstr("1.1 x"));
  EXPECT_THAT(finished.output,
              AllOf(HasSubstr("statusword  0x250 Switch on disabled: voltage enabled, remote"),
                    HasSubstr("owner       free"), HasSubstr("lockstep, 1000 us a tick"),
                    HasSubstr("last fault  none"), HasSubstr("faults      0 since power-up"),
                    HasSubstr("rotary, deg; 4096 UU are one revolution"),
                    HasSubstr("modes       profile position, velocity, profile velocity"),
                    HasSubstr("rated 3000 mN.m and 5000 mA")));
}

// The default of 6081h is 68267.
TEST_F(Describe, ListsAnObjectWhileItDiffersFromItsDefault) {
  EXPECT_THAT(objects_called(description_of("1.1"), "profile_velocity"), IsEmpty());
  ASSERT_EQ(call("write 1.1 profile_velocity 1000").code, 0);
  std::vector<Json> changed = objects_called(description_of("1.1"), "profile_velocity");
  ASSERT_THAT(changed, SizeIs(1));
  // 4096 UU are 360 deg.
  EXPECT_NEAR(changed[0]["value_in_unit"], 1'000 * 360.0 / 4'096.0, 1e-9);
  EXPECT_NEAR(changed[0]["default_in_unit"], 68'267 * 360.0 / 4'096.0, 1e-9);
  changed[0].erase("value_in_unit");
  changed[0].erase("default_in_unit");
  EXPECT_EQ(changed[0], (Json{{"index", "0x6081"},
                              {"subindex", 0},
                              {"name", "profile_velocity"},
                              {"value", 1000},
                              {"unit", "deg/s"},
                              {"default", 68267},
                              {"units", "VelUU"}}));
  EXPECT_THAT(call("describe 1.1").output,
              testing::ContainsRegex("0x6081 +profile_velocity +1000 UU/s .87.89 deg/s. +"
                                     "68267 UU/s .6000.03 deg/s. +VelUU"));
  EXPECT_THAT(objects_called(description_of("1.2"), "profile_velocity"), IsEmpty());
  ASSERT_EQ(call("write 1.1 profile_velocity 68267").code, 0);
  EXPECT_THAT(objects_called(description_of("1.1"), "profile_velocity"), IsEmpty());
}

// 2310h: continuous over-current.
TEST_F(Describe, ShowsTheLastFaultWithTheTickOfItsEvent) {
  EXPECT_TRUE(description_of("1.1")["fault"].is_null());
  ASSERT_EQ(call("run -", "enable 1.1\ndisturb 1.1 over_current\nwait 5ms\n").code, 0);
  std::vector<Json> faults;
  for (const Json& event : json_of(call("events 1.1 --json"))) {
    if (event["kind"] == "fault") faults.push_back(event);
  }
  ASSERT_THAT(faults, SizeIs(1));
  const Json present = description_of("1.1")["fault"];
  EXPECT_EQ(present, (Json{{"code", 0x2310},
                           {"name", "continuous over-current"},
                           {"is_present", true},
                           {"tick", faults[0]["tick"]}}));
  // The drive refuses the reset while the cause persists.
  ASSERT_EQ(call("disturb 1.1 none").code, 0);
  ASSERT_EQ(call("reset 1.1").code, 0);
  EXPECT_EQ(description_of("1.1")["fault"]["is_present"], false);
  EXPECT_THAT(call("describe 1.1").output,
              AllOf(HasSubstr("last fault  0x2310 continuous over-current in tick " +
                              faults[0]["tick"].dump() + ", reset"),
                    HasSubstr("faults      1 since power-up")));
}

TEST_F(Describe, PrintsTheDocumentedJson) {
  const Json description = description_of("1.1");
  EXPECT_THAT(keys(description["model"]),
              ElementsAre("unit_kind", "unit_size", "modes", "user_position_lower_limit",
                          "user_position_upper_limit", "app_speed_limit",
                          "user_position_lower_limit_in_unit", "user_position_upper_limit_in_unit",
                          "app_speed_limit_in_unit", "motor_type", "motor_rated_torque",
                          "motor_rated_current", "motor_max_speed_rpm", "gear_ratio_numerator",
                          "gear_ratio_denominator"));
  for (const char* const key :
       {"axis", "name", "tick", "state", "flags", "ds402_statusword", "load_position_actual_value",
        "owner", "unit", "position_in_unit", "mode", "bench", "bench_name", "clock", "period_us",
        "fault", "model", "objects_tick", "objects"}) {
    EXPECT_TRUE(description.contains(key)) << key;
  }
  EXPECT_EQ(description["axis"], "1.1");
  EXPECT_EQ(description["mode"], "none");
  EXPECT_EQ(description["model"]["unit_size"], 4096.0);
}

TEST_F(Describe, ShowsSeveralAxesAndRefusesUnknownOnes) {
  const std::vector<Json> both = json_of(call("describe y 1.1 --json"));
  ASSERT_THAT(both, SizeIs(2));
  EXPECT_EQ(both[0]["axis"], "1.2");
  EXPECT_EQ(both[1]["axis"], "1.1");
  EXPECT_THAT(json_of(call("describe --all --json")), SizeIs(2));
  const Finished unknown = call("describe 1.9");
  EXPECT_EQ(unknown.code, 3);
  EXPECT_THAT(unknown.errors, HasSubstr("1.9"));
  EXPECT_EQ(call("describe").code, 2);
}

TEST_F(Describe, NamesTheOwner) {
  // The session of the scenario owns the axis that it describes.
  const Finished finished = call("run -", "enable 1.1\ndescribe 1.1\n");
  ASSERT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output,
              AllOf(HasSubstr("owner       0x"), Not(HasSubstr("owner       free")),
                    HasSubstr("Operation enabled")));
}

}  // namespace
}  // namespace vdrive::test

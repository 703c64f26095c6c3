// SPDX-License-Identifier: Apache-2.0
// Units of axes, on the command line and in scenarios.
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/quantity.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// A rotary and a linear axis, enabled, in lock-step.
class Units : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(call("enable turn").code, 0);
    ASSERT_EQ(call("enable slide").code, 0);
  }

  [[nodiscard]] std::string file(const std::string& name, const std::string& text) const {
    const std::string path = (directory_.path() / name).string();
    std::ofstream(path) << text;
    return path;
  }

  [[nodiscard]] static std::string value_of(const std::string& axis, const std::string& object) {
    return nlohmann::json::parse(call("read " + axis + " " + object + " --json").output)["value"]
        .dump();
  }

 private:
  TemporaryDirectory directory_;
  BenchOnWire bench_{"--config " + file("bench.yaml", R"(
clock: {mode: lockstep}
axes:
  - {number: 1, name: turn}
  - {number: 2, name: slide, unit: {kind: linear, name: mm, per_unit: 1000}}
)")};
};

// 90 of 360 deg are 1024 of 4096 UU; 12.5 mm are 12500 UU.
TEST_F(Units, OfEachAxisAreAcceptedAndShown) {
  const Finished turned = call("move turn 90deg --velocity 180deg/s");
  ASSERT_EQ(turned.code, 0) << turned.errors;
  EXPECT_THAT(turned.output, HasSubstr("1024 UU    90.00 deg"));
  EXPECT_EQ(value_of("turn", "0x6062"), "1024");
  ASSERT_EQ(call("move slide 12.5mm").code, 0);
  EXPECT_EQ(value_of("slide", "0x6062"), "12500");
  ASSERT_EQ(call("move slide -0.5cm --relative").code, 0);
  EXPECT_EQ(value_of("slide", "0x6062"), "7500");
  EXPECT_THAT(call("status slide").output, HasSubstr("7.500 mm"));
  const auto status = nlohmann::json::parse(call("status slide --json").output);
  EXPECT_EQ(status["unit"], "mm");
  EXPECT_NEAR(status["position_in_unit"], 7.5, 0.005) << "0.005 mm are 5 UU";
}

TEST_F(Units, AreAcceptedByWrite) {
  ASSERT_EQ(call("write slide profile_velocity 10mm/s").code, 0);
  EXPECT_EQ(value_of("slide", "0x6081"), "10000");
  ASSERT_EQ(call("write turn 0x6081 60rpm").code, 0);
  EXPECT_EQ(value_of("turn", "0x6081"), "4096");
}

TEST_F(Units, ThatAnAxisDoesNotHaveAreAUsageError) {
  const Finished refused = call("move slide 90deg");
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("axis slide has no unit 'deg'; it has mm, m, cm, um, UU"));
  const Finished range = call("move turn 1e9deg");
  EXPECT_EQ(range.code, 2);
  EXPECT_THAT(range.errors,
              HasSubstr("must be from -2147483648 UU (-188743680.00 deg) to 2147483647 UU (1887"));
  EXPECT_EQ(value_of("turn", "0x6062"), "0");
}

/// An object that is a position, a velocity, an acceleration or a jerk.
struct MeasuredObject {
  ObjectRow row;
  Dimension dimension;

  [[nodiscard]] std::string name() const { return std::string(describe(row).variable_name); }

  /// @return a typed value, such as "12mm/s2".
  [[nodiscard]] std::string in(const std::string& number, const std::string& unit) const {
    return number + unit + std::string(unit_ending(dimension));
  }

  /// @return the value in a message, such as "12000 UU/s2 (12.000 mm/s2)".
  [[nodiscard]] std::string told(const std::string& user_units, const std::string& shown) const {
    const std::string ending(unit_ending(dimension));
    return user_units + " UU" + ending + " (" + shown + ending + ")";
  }
};

/// Classifies objects by the units text of the dictionary, as a reader of the table would.
std::vector<MeasuredObject> measured_objects(Access access) {
  std::vector<MeasuredObject> objects;
  for (std::size_t place = 0; place < kObjectTable.size(); ++place) {
    const auto row = static_cast<ObjectRow>(place);
    const std::string units(describe(row).units);
    const auto begins = [&units](const char* word) {
      return units.rfind(word, 0) == 0;
    };
    const bool is_position = begins("Pos") || units == "p";
    if (describe(row).access != access) continue;
    if (is_position) objects.push_back({row, Dimension::position});
    if (begins("Vel")) objects.push_back({row, Dimension::velocity});
    if (begins("Acc")) objects.push_back({row, Dimension::acceleration});
    if (begins("Jerk")) objects.push_back({row, Dimension::jerk});
  }
  return objects;
}

// 12 mm are 12000 UU; 13 mm are another value, and 1e15 mm exceed any type.
TEST_F(Units, AreWrittenReadAndToldForEveryObjectThatHasOne) {
  const auto objects = measured_objects(Access::read_write);
  ASSERT_GE(objects.size(), 30U);
  for (const MeasuredObject& object : objects) {
    SCOPED_TRACE(object.name());
    const std::string value = object.told("12000", "12.000 mm");
    const Finished written = call("write slide " + object.name() + " " + object.in("12", "mm"));
    ASSERT_EQ(written.code, 0) << written.errors;
    EXPECT_THAT(written.output, HasSubstr("= " + value + ", in force at tick"));
    EXPECT_THAT(call("read slide " + object.name()).output, HasSubstr("= " + value));
    const auto read = nlohmann::json::parse(call("read slide " + object.name() + " --json").output);
    EXPECT_EQ(read["value"], 12'000);
    EXPECT_EQ(read["value_in_unit"], 12.0);
    EXPECT_EQ(read["unit"], object.in("", "mm"));
    const Finished other = call("expect slide " + object.name() + " " + object.in("13", "mm"));
    EXPECT_EQ(other.code, 1);
    EXPECT_THAT(other.errors,
                HasSubstr("expected " + object.told("13000", "13.000 mm") + ", actual " + value));
    const Finished foreign = call("write slide " + object.name() + " " + object.in("1", "deg"));
    EXPECT_EQ(foreign.code, 2);
    EXPECT_THAT(foreign.errors,
                HasSubstr("has no unit 'deg'; it has " + object.in("", "mm") + ","));
    const Finished large = call("write slide " + object.name() + " " + object.in("1e15", "mm"));
    EXPECT_EQ(large.code, 2);
    EXPECT_THAT(large.errors, AllOf(HasSubstr(" mm" + object.in("", "") + ") to "),
                                    HasSubstr(" mm" + object.in("", "") + ")\n")));
  }
}

TEST_F(Units, AreShownForEveryObjectThatCanOnlyBeRead) {
  const auto objects = measured_objects(Access::read_only);
  ASSERT_GE(objects.size(), 10U);
  for (const MeasuredObject& object : objects) {
    SCOPED_TRACE(object.name());
    EXPECT_THAT(call("read turn " + object.name()).output,
                HasSubstr(" deg" + object.in("", "") + ")"));
  }
}

// 40000 mm/s³ are 40 million UU/s³.
TEST_F(Units, OfAJerkAreTakenAndToldWhereItIsRefused) {
  const Finished written = call("write slide profile_jerk_1 40000mm/s3");
  ASSERT_EQ(written.code, 0) << written.errors;
  EXPECT_THAT(written.output, HasSubstr("= 40000000 UU/s3 (40000.000 mm/s3)"));
  EXPECT_EQ(value_of("slide", "0x60A4:1"), "40000000");
  EXPECT_THAT(call("write slide profile_jerk_1 0mm/s3").errors,
              HasSubstr("profile_jerk_1 accepts 1 UU/s3 (0.001 mm/s3) to 4294967295 UU/s3"));
}

/// A command that fails, and the part of its message that uses the unit of the axis.
struct ToldFailure {
  std::string command;
  std::string message;
};

TEST_F(Units, AreToldInTheMessagesOfCommandsThatFail) {
  ASSERT_EQ(call("write slide 607Dh:1 -20mm").code, 0);
  ASSERT_EQ(call("write slide 607Dh:2 20mm").code, 0);
  ASSERT_EQ(call("write slide 3535h 1").code, 0);
  const std::vector<ToldFailure> failures{
      {"move slide 25mm --velocity 100mm/s",
       "(607Dh:2) = 20000 UU (20.000 mm) cut short the move to 25000 UU (25.000 mm)"},
      {"move slide 0 --velocity 1000mm/s",
       "the velocity 1000000 UU/s (1000.000 mm/s) is above app_speed_limit (607Fh) = 136533 UU/s "
       "(136.533 mm/s)"},
      {"home slide --method 17 --speed 1000mm/s",
       "1000000 UU/s (1000.000 mm/s) is above app_speed_limit (607Fh) = 136533 UU/s (136.533 "
       "mm/s)"},
      {"velocity slide -1000mm/s",
       "the velocity -1000000 UU/s (-1000.000 mm/s) is above app_speed_limit (607Fh) = 136533"},
      {"jog slide 1000mm/s --for 10ms", "1000000 UU/s (1000.000 mm/s) is above app_speed_limit"},
      {"move slide 0 --velocity 1mm/s --timeout 10ms", " of 0 UU (0.000 mm), still moving at -"},
      {"velocity slide 10mm/s --acceleration 1mm/s2 --timeout 10ms",
       " of 10000 UU/s (10.000 mm/s), still changing"},
      {"home slide --method 17 --speed 1mm/s --timeout 10ms",
       ", still moving at -1000 UU/s (-1.000 mm/s)"},
      {"wait slide position > 30mm --timeout 10ms", "expected > 30000 UU (30.000 mm), actual "},
      {"expect slide velocity 5mm/s --tolerance 1mm/s",
       "expected 5000 UU/s (5.000 mm/s) +- 1000 UU/s (1.000 mm/s), actual "},
  };
  for (const ToldFailure& failure : failures) {
    const Finished failed = call(failure.command);
    EXPECT_NE(failed.code, 0) << failure.command;
    EXPECT_THAT(failed.errors, HasSubstr(failure.message)) << failure.command;
    ASSERT_EQ(call("halt slide --wait").code, 0) << failure.command;
    ASSERT_EQ(call("resume slide").code, 0) << failure.command;
  }
  ASSERT_EQ(call("disturb slide positive_limit").code, 0);
  EXPECT_THAT(
      call("move slide 30mm").errors,
      AllOf(HasSubstr("ended the move to 30000 UU (30.000 mm) at position "), HasSubstr(" mm)")));
}

TEST_F(Units, OfAScenarioAreCheckedBeforeItsFirstCommand) {
  const Finished refused = call("run " + file("bad.scn", "move turn 90deg\nmove slide 3deg\n"));
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("bad.scn:2: '3deg': axis slide has no unit 'deg'"));
  EXPECT_EQ(value_of("turn", "0x6062"), "0");
  const Finished several =
      call("run " + file("both.scn", "move turn 2mm\nmove slide 3deg\nenable gone\n"));
  EXPECT_EQ(several.code, 2);
  EXPECT_THAT(several.errors, AllOf(HasSubstr("both.scn:1: '2mm'"), HasSubstr("both.scn:2: '3deg'"),
                                    HasSubstr("both.scn:3: no axis is named 'gone'")));
  const Finished passed = call("run " + file("good.scn",
                                             "move turn 90deg\n"
                                             "expect turn position_demand_value 0.25rev\n"
                                             "expect turn 0x6064 89deg --tolerance 1.5deg\n"));
  EXPECT_EQ(passed.code, 0) << passed.errors;
  EXPECT_EQ(call("run " + file("off.scn", "expect turn 0x6064 80deg --tolerance 1deg\n")).code, 1);
}

}  // namespace
}  // namespace vdrive::test

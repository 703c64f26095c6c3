// SPDX-License-Identifier: Apache-2.0
#include "configuration/mechanics.hpp"

#include "configuration/axis_units.hpp"
#include "configuration/configuration_file.hpp"
#include "configuration/configuration_warnings.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Configuration bench_in(const std::string& text) {
  return parse_configuration(text, "bench.yaml");
}

/// @return the only axis of a bench; `rest` has its other keys.
NamedAxis axis_with(const std::string& mechanics, const std::string& rest = "") {
  return bench_in("axes:\n  - number: 1\n    mechanics: " + mechanics + "\n" + rest).axes.front();
}

std::string refusal_of_mechanics(const std::string& mechanics, const std::string& rest = "") {
  try {
    static_cast<void>(axis_with(mechanics, rest));
  } catch (const ConfigurationError& error) {
    return error.what();
  }
  return "accepted";
}

// 4096 UU for a turn of the load over 5 mm are 819.2 UU/mm. 2000 rpm at the motor are 200 rpm at
// the screw: 200 x 4096 / 60 = 13653.3 UU/s. The ramps are a tenth of the default axis's.
TEST(Mechanics, OfAScrewGiveUnitGearAndSpeeds) {
  const NamedAxis axis = axis_with("{screw: {pitch: 5mm}, gear: 10:1}");
  EXPECT_EQ(axis.unit, (Unit{.kind = UnitKind::linear, .name = "mm", .size = 819.2}));
  const AxisConfiguration& configuration = axis.configuration;
  EXPECT_EQ(value_at_start(configuration, "gear_ratio_numerator"_object), 1);
  EXPECT_EQ(value_at_start(configuration, "gear_ratio_denominator"_object), 10);
  EXPECT_EQ(value_at_start(configuration, "app_speed_limit"_object), 13'653);
  EXPECT_EQ(value_at_start(configuration, "profile_velocity"_object), 6'826);
  EXPECT_EQ(value_at_start(configuration, "profile_acc"_object), 40'960);
  EXPECT_EQ(value_at_start(configuration, "quick_stop_deceleration"_object), 204'800);
  EXPECT_EQ(value_at_start(configuration, "homing_speed_search"_object), 3'413);
  const AxisBank bank(std::span(&configuration, 1), std::chrono::microseconds{1'000});
  EXPECT_EQ(bank.read(0, {0x5E11, 0}).value, 13'653) << "what the drive makes of it";
}

// 6064h counts at the motor, with 40960 UU for a turn of the screw; the speeds of the motor are
// unchanged.
TEST(Mechanics, OfAnAxisWithOneEncoderCountAtItsMotor) {
  const NamedAxis axis = axis_with("{screw: {pitch: 5mm, starts: 2}, gear: 10:1}",
                                   "    model: {feedback: single_encoder}\n");
  EXPECT_DOUBLE_EQ(axis.unit.size, 4'096.0);  // 40960 UU over 10 mm
  EXPECT_EQ(value_at_start(axis.configuration, "app_speed_limit"_object), 136'533);
  EXPECT_EQ(value_at_start(axis.configuration, "profile_acc"_object), 409'600);
}

TEST(Mechanics, OfBeltRackAndTableFollowTheirCircumference) {
  EXPECT_DOUBLE_EQ(axis_with("{belt: {teeth: 20, pitch: 5mm}}").unit.size, 40.96);
  EXPECT_DOUBLE_EQ(axis_with("{rack: {diameter: 4cm}}").unit.size,
                   4'096.0 / 4.0 / std::numbers::pi);
  EXPECT_EQ(axis_with("{rack: {diameter: 4cm}}").unit.name, "cm");
  EXPECT_EQ(axis_with("{rotary_table: deg, gear: 50:1}").unit, Unit());
}

// 10 mm are 8192 UU, 300 mm are 245760 UU.
TEST(Mechanics, MayHaveSoftwareLimitsInUnits) {
  const NamedAxis axis = axis_with("{screw: {pitch: 5mm}, software_limit: [-10mm, 0.3m]}");
  EXPECT_EQ(value_at_start(axis.configuration, "user_position_lower_limit"_object), -8'192);
  EXPECT_EQ(value_at_start(axis.configuration, "user_position_upper_limit"_object), 245'760);
  EXPECT_EQ(value_at_start(axis.configuration, "app_position_limit_switch"_object), 1);
}

// 5 mm/s are a turn a second, 4096 UU/s.
TEST(Mechanics, LetParametersBeWrittenInUnits) {
  const NamedAxis axis =
      axis_with("{screw: {pitch: 5mm}}",
                "    initial_position: 10mm\n"
                "    parameters: {profile_velocity: 5mm/s, profile_acc: 0.05m/s2, "
                "app_speed_limit: 8192}\n");
  EXPECT_EQ(axis.configuration.initial_position, 8'192);
  EXPECT_EQ(value_at_start(axis.configuration, "profile_velocity"_object), 4'096);
  EXPECT_EQ(value_at_start(axis.configuration, "profile_acc"_object), 40'960);
  EXPECT_EQ(value_at_start(axis.configuration, "app_speed_limit"_object), 8'192);
}

TEST(Mechanics, ReadTheirKeysInAnyOrder) {
  const NamedAxis axis = bench_in(
                             "axes:\n"
                             "  - parameters: {profile_velocity: 5mm/s}\n"
                             "    initial_position: 5mm\n"
                             "    mechanics: {software_limit: [0mm, 5mm], screw: {pitch: 5mm}}\n"
                             "    model: {feedback: single_encoder}\n"
                             "    number: 3\n")
                             .axes.front();
  EXPECT_EQ(axis.configuration.initial_position, 4'096);
  EXPECT_EQ(value_at_start(axis.configuration, "profile_velocity"_object), 4'096);
}

TEST(Mechanics, ArePrintedAsWhatFollowsFromThem) {
  const Configuration read =
      bench_in("axes: [{number: 1, mechanics: {belt: {diameter: 40mm}, gear: 3:1}}]");
  const Configuration again = bench_in(to_yaml(read));
  EXPECT_EQ(again.axes[0].unit, read.axes[0].unit);
  EXPECT_EQ(to_yaml(again), to_yaml(read));
  EXPECT_EQ(value_at_start(again.axes[0].configuration, "app_speed_limit"_object), 45'511);
}

TEST(Mechanics, ThatAreNoMechanicsAreRefusedWithLineValueAndExample) {
  const std::string place = "bench.yaml:3: axes[0].mechanics";
  EXPECT_THAT(refusal_of_mechanics("{gear: 2:1}"),
              HasSubstr(place + ": must have exactly one of screw"));
  EXPECT_THAT(refusal_of_mechanics("{screw: {pitch: 5mm}, rotary_table: deg}"),
              HasSubstr("exactly one"));
  EXPECT_EQ(refusal_of_mechanics("{screw: {}}"),
            place + ".screw: a screw needs its pitch, such as {pitch: 5mm}");
  for (const char* const pitch : {"5", "0mm", "-5mm", "5deg", "mm", "1e400mm"}) {
    EXPECT_EQ(refusal_of_mechanics(std::string("{screw: {pitch: ") + pitch + "}}"),
              place + ".screw.pitch = " + pitch +
                  ": must be a length above 0 with its unit, such as 5mm (m, cm, mm, um)");
  }
  for (const char* const gear : {"10", "0:1", "1:0", "10:1:1", "2.5:1", "4294967296:1"}) {
    EXPECT_THAT(refusal_of_mechanics(std::string("{rotary_table: deg, gear: \"") + gear + "\"}"),
                HasSubstr(place + ".gear = " + gear + ": must be turns of the motor"));
  }
  EXPECT_THAT(refusal_of_mechanics("{belt: {teeth: 20}}"), HasSubstr("needs either the diameter"));
  EXPECT_THAT(refusal_of_mechanics("{belt: {diameter: 4cm, teeth: 20, pitch: 5mm}}"),
              HasSubstr("needs either the diameter"));
  EXPECT_THAT(refusal_of_mechanics("{rotary_table: mm}"), HasSubstr("deg, rad or rev"));
  EXPECT_THAT(refusal_of_mechanics("{screw: {pitch: 1e12m}}"),
              HasSubstr("would have 4.096e-09 user units"));
}

TEST(Mechanics, RefuseWhatContradictsThemWithBothValues) {
  EXPECT_EQ(refusal_of_mechanics("{screw: {pitch: 5mm}}",
                                 "    unit: {kind: linear, name: mm, per_unit: 1000}\n"),
            "bench.yaml:4: axes[0].unit: contradicts mechanics, from which {kind: linear, name: "
            "mm, per_unit: 819.2} follows; remove it");
  EXPECT_EQ(refusal_of_mechanics("{screw: {pitch: 5mm}, gear: 10:1}",
                                 "    parameters: {gear_ratio_denominator: 5}\n"),
            "bench.yaml:4: axes[0].parameters.gear_ratio_denominator = 5: contradicts mechanics, "
            "from which gear_ratio_denominator = 10 follows");
  EXPECT_EQ(refusal_of_mechanics("{screw: {pitch: 5mm}}",
                                 "    unit: {kind: linear, name: mm, per_unit: 819.2}\n"),
            "accepted");
  EXPECT_THAT(refusal_of_mechanics("{screw: {pitch: 5mm}, software_limit: [3mm, 2mm]}"),
              HasSubstr("the lower limit, 2458 UU (3.000 mm), must be below the upper one, 1638 "
                        "UU (2.000 mm)"));
  EXPECT_THAT(refusal_of_mechanics("{screw: {pitch: 5mm}, software_limit: [3mm]}"),
              HasSubstr("such as [-10mm, 300mm]"));
}

TEST(Mechanics, DoNotHideOtherMistakesOfTheirAxis) {
  const std::string refusal =
      refusal_of_mechanics("{screw: {pitch: 5mm}}",
                           "    initial_position: 5deg\n"
                           "    parameters: {profil_velocity: 3, homing_method: 36}\n"
                           "    name: 5\n");
  for (const char* const mistake : {"bench.yaml:4: axes[0].initial_position", "profil_velocity",
                                    "homing_method = 36", "bench.yaml:6: axes[0].name"}) {
    EXPECT_THAT(refusal, HasSubstr(mistake));
  }
  const std::string wrong =
      refusal_of_mechanics("{screw: {pitch: 5}}", "    parameters: {profile_velocity: 3mm/s}\n");
  EXPECT_THAT(wrong, HasSubstr("mechanics.screw.pitch = 5"));
  EXPECT_THAT(wrong, Not(HasSubstr("profile_velocity"))) << "its unit is not known";
}

// 5 mm over 4096 UU are 1.2207 um.
TEST(Mechanics, RefuseAFinerResolutionThanThatOfAUserUnit) {
  EXPECT_EQ(refusal_of_mechanics("{screw: {pitch: 5mm}, resolution: 1um}"),
            "bench.yaml:3: axes[0].mechanics.resolution = 1um: is finer than one user unit (1.2207 "
            "um): a turn of the load has 4096 user units");
  EXPECT_EQ(refusal_of_mechanics("{screw: {pitch: 5mm}, resolution: 1.3um}"), "accepted");
  // 4.096 mm are 4096 user units of 1 um; neither length is exact in binary.
  EXPECT_EQ(refusal_of_mechanics("{screw: {pitch: 0.4096cm}, resolution: 1um}"), "accepted");
  EXPECT_THAT(refusal_of_mechanics("{screw: {pitch: 5mm}, resolution: 2}"),
              HasSubstr("with its unit"));
  EXPECT_THAT(refusal_of_mechanics("{rotary_table: deg, resolution: 1um}"),
              HasSubstr("the axis has deg"));
}

TEST(Mechanics, NameTheUnitsOfTheAxisWhereAnotherOneIsWritten) {
  EXPECT_EQ(
      refusal_of_mechanics("{screw: {pitch: 5mm}}", "    parameters: {profile_velocity: 5deg/s}\n"),
      "bench.yaml:4: axes[0].parameters.profile_velocity = 5deg/s: the axis has no such unit; "
      "it has mm/s, m/s, cm/s, um/s, UU/s");
  EXPECT_EQ(
      refusal_of_mechanics("{screw: {pitch: 5mm}}", "    parameters: {profile_velocity: fast}\n"),
      "bench.yaml:4: axes[0].parameters.profile_velocity = fast: must be a whole number from 0 "
      "UU/s (0.000 mm/s) to 4294967295 UU/s (5242879.999 mm/s), or a value with a unit of the "
      "axis: mm/s, m/s, cm/s, um/s, UU/s");
  EXPECT_THAT(refusal_of_mechanics("{screw: {pitch: 5mm}}", "    initial_position: 5km\n"),
              HasSubstr("the axis has no such unit; it has mm, m, cm, um, UU"));
  EXPECT_THAT(refusal_of_mechanics("{screw: {pitch: 5mm}}", "    initial_position: 1e9mm\n"),
              HasSubstr("is 8.192e+11 UU: must be from -2147483648 UU (-2621440.000 mm) to "
                        "2147483647 UU (2621439.999 mm)"));
}

// The default axis: 2000 rpm are 12000 deg/s, but 607Fh = 136533 UU/s cuts the last 0.03 deg/s.
TEST(Mechanics, AreATableWithALineForAxesThatAreAlike) {
  const Configuration bench = bench_in(
      "axes:\n"
      "  - {number: 1, mechanics: &screw {screw: {pitch: 5mm}, gear: 10:1, software_limit: [-10mm, "
      "300mm]}}\n"
      "  - {number: 2, mechanics: *screw}\n"
      "  - {number: 3}\n"
      "  - {number: 4, mechanics: *screw}\n"
      "  - {number: 5, mechanics: *screw}\n");
  EXPECT_THAT(
      mechanics_table(bench),
      ElementsAre(
          "axes      a turn of the load  a user unit    highest speed  gear  software limits",
          "1-2, 4-5  5 mm                1.2207 um      16.6663 mm/s   10:1  -10.000 mm to 300.000 "
          "mm",
          "3         360 deg             0.0878906 deg  12000 deg/s    1:1   none"));
}

TEST(Mechanics, AreAdvisedWhereAUnitContradictsTheDrive) {
  EXPECT_THAT(
      start_warnings(bench_in("axes: [{number: 1, unit: {kind: rotary, per_revolution: 36000}}]")),
      ElementsAre("bench.yaml:1: axes[0].unit: axis 1 axis1: unit has per_revolution = 36000, but "
                  "a revolution of the load has 4096 user units, so all angles are displayed "
                  "wrong; use mechanics: {rotary_table: deg} instead of unit"));
  EXPECT_THAT(start_warnings(bench_in("axes: [{number: 1, mechanics: {rotary_table: deg}}]")),
              IsEmpty());
  EXPECT_THAT(start_warnings(
                  bench_in("axes: [{number: 1, mechanics: {rotary_table: rev, gear: 5:1}, model: "
                           "{feedback: single_encoder}}]")),
              IsEmpty());
}

// 2000 rpm at the motor are 13653.3 UU/s after a gear of 10:1.
TEST(Mechanics, WarnOfASpeedLimitThatTheMotorDoesNotReach) {
  const std::string axis =
      "axes: [{number: 1, parameters: {gear_ratio_denominator: 10, app_speed_limit: ";
  EXPECT_THAT(
      start_warnings(bench_in(axis + "13654}}]")),
      ElementsAre(
          "bench.yaml:1: axes[0].parameters.app_speed_limit = 13654: axis 1 axis1: app_speed_limit "
          "= 13654 UU/s (1200.06 deg/s) is above 13653 UU/s (1199.97 deg/s), the speed at "
          "motor_max_speed_rpm (6080h) = 2000: the lower limit applies"));
  EXPECT_THAT(start_warnings(bench_in(axis + "13653}}]")), IsEmpty());
}

/// @return the warnings of a bench with one axis; `keys` follow its number.
std::vector<std::string> warnings_of_axis(const std::string& keys) {
  return start_warnings(bench_in("axes: [{number: 1, " + keys + "}]"));
}

// A turn is 4096 UU; at a micrometre each, that is 4.096 mm.
TEST(Mechanics, AreAdvisedWhereAUserUnitIsSaidToBeADecimalPartOfALength) {
  EXPECT_THAT(warnings_of_axis("unit: {kind: linear, name: um, per_unit: 1}"),
              ElementsAre("bench.yaml:1: axes[0].unit: axis 1 axis1: unit has per_unit = 1, and a "
                          "revolution of the load has 4096 user units, that is a lead of 4.096 mm; "
                          "if the lead of the machine differs, all lengths are displayed wrong: "
                          "use mechanics: {screw: {pitch: 4096um}} with its lead instead of unit"));
  EXPECT_THAT(warnings_of_axis("unit: {kind: linear, name: mm, per_unit: 1000}"),
              ElementsAre(HasSubstr("that is a lead of 4.096 mm; ")));
  // A hundredth of a millimetre. With one encoder, on the motor's side of a gear of 10:1, a turn of
  // the load has 40960 UU.
  EXPECT_THAT(warnings_of_axis("unit: {kind: linear, name: mm, per_unit: 100}, model: {feedback: "
                               "single_encoder}, parameters: {gear_ratio_denominator: 10}"),
              ElementsAre(HasSubstr("{screw: {pitch: 409.6mm}}")));
}

TEST(Mechanics, AreNotAdvisedBesideAUnitThatFitsThem) {
  for (const char* const unit :
       {"unit: {kind: linear, name: mm, per_unit: 819.2}",
        "unit: {kind: linear, name: bottle, per_unit: 1}", "mechanics: {screw: {pitch: 4096um}}",
        "mechanics: {screw: {pitch: 4096um}}, unit: {kind: linear, name: "
        "um, per_unit: 1}"}) {
    EXPECT_THAT(warnings_of_axis(unit), IsEmpty()) << unit;
  }
}

// 300 UU of 5 mm / 4096 are 0.366 mm.
TEST(Mechanics, WarnOfASoftwareLimitWithoutAUnitAndTakeItAsUserUnits) {
  const Configuration bench = bench_in(
      "axes:\n"
      "  - number: 1\n"
      "    mechanics:\n"
      "      screw: {pitch: 5mm}\n"
      "      software_limit:\n"
      "        - 0\n"
      "        - 300\n");
  EXPECT_THAT(start_warnings(bench),
              ElementsAre("bench.yaml:7: axes[0].mechanics.software_limit[1] = 300: axis 1 axis1: "
                          "300 means 300 UU = 0.366 mm; write 300mm, or 300UU"));
  EXPECT_EQ(value_at_start(bench.axes[0].configuration, "user_position_upper_limit"_object), 300);
  for (const char* const limits : {"[0, 300UU]", "[0, 300mm]", "[-300 UU, 0]"}) {
    EXPECT_THAT(warnings_of_axis(std::string("mechanics: {screw: {pitch: 5mm}, software_limit: ") +
                                 limits + "}"),
                IsEmpty())
        << limits;
  }
}

// 2000 rpm at the motor are 13653.3 UU/s after a gear of 10:1; 4096 UU are 360 deg.
TEST(Mechanics, WarnOfAProfileVelocityThatTheMotorDoesNotReach) {
  const std::string gear = "parameters: {gear_ratio_denominator: 10, profile_velocity: ";
  EXPECT_THAT(
      warnings_of_axis(gear + "20000}"),
      ElementsAre("bench.yaml:1: axes[0].parameters.profile_velocity = 20000: axis 1 axis1: "
                  "profile_velocity = 20000 UU/s (1757.81 deg/s) is above 13653 UU/s (1199.97 "
                  "deg/s), the highest speed with motor_max_speed_rpm (6080h) = 2000: the drive "
                  "keeps the value and moves at the lower speed"));
  EXPECT_THAT(warnings_of_axis(gear + "13653}"), IsEmpty());
}

// 819.2 UU are a millimetre. 607Fh follows from the motor: 13653 UU/s.
TEST(Mechanics, WarnOfAProfileVelocityAboveTheSpeedLimit) {
  const std::string limit = "parameters: {app_speed_limit: 1000, profile_velocity: ";
  EXPECT_THAT(warnings_of_axis(limit + "1001}"),
              ElementsAre(HasSubstr("profile_velocity = 1001 UU/s (87.98 deg/s) is above 1000 "
                                    "UU/s (87.89 deg/s), the highest speed with app_speed_limit "
                                    "(607Fh) = 1000 UU/s (87.89 deg/s): ")));
  EXPECT_THAT(warnings_of_axis(limit + "1000}"), IsEmpty());
  const std::string screw = "mechanics: {screw: {pitch: 5mm}, gear: 10:1}, parameters: {";
  EXPECT_THAT(warnings_of_axis(screw + "profile_velocity: 20mm/s}"),
              ElementsAre(HasSubstr("profile_velocity = 16384 UU/s (20.000 mm/s) is above 13653 "
                                    "UU/s (16.666 mm/s), the highest speed with app_speed_limit "
                                    "(607Fh) = 13653 UU/s (16.666 mm/s): ")));
  EXPECT_THAT(warnings_of_axis(screw + "app_speed_limit: 1mm/s}"), IsEmpty())
      << "the file gives no profile_velocity";
}

}  // namespace
}  // namespace vdrive::service

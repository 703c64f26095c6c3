// SPDX-License-Identifier: Apache-2.0
// Units of axes on the command line and in scenarios.
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <string>

namespace vdrive::test {
namespace {

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
  EXPECT_THAT(range.errors, HasSubstr("must be from -2147483648 to 2147483647 UU"));
  EXPECT_EQ(value_of("turn", "0x6062"), "0");
}

TEST_F(Units, OfAScenarioAreCheckedBeforeItsFirstCommand) {
  const Finished refused = call("run " + file("bad.scn", "move turn 90deg\nmove slide 3deg\n"));
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("bad.scn:2: '3deg': axis slide has no unit 'deg'"));
  EXPECT_EQ(value_of("turn", "0x6062"), "0");
  const Finished passed = call("run " + file("good.scn",
                                             "move turn 90deg\n"
                                             "expect turn position_demand_value 0.25rev\n"
                                             "expect turn 0x6064 89deg --tolerance 1.5deg\n"));
  EXPECT_EQ(passed.code, 0) << passed.errors;
  EXPECT_EQ(call("run " + file("off.scn", "expect turn 0x6064 80deg --tolerance 1deg\n")).code, 1);
}

}  // namespace
}  // namespace vdrive::test

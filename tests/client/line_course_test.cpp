// SPDX-License-Identifier: Apache-2.0
// The targets that are valid for a line that starts while its axes move.
#include "groups/line_course.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

AxisSnapshot moving_axis(std::uint16_t number, std::int32_t position, std::int32_t velocity) {
  AxisSnapshot axis;
  axis.id = {1, number};
  axis.status.position_demand_value = position;
  axis.status.velocity_demand_value = velocity;
  return axis;
}

/// Two axes in the middle of a line over 9000 and -3000 UU, moving at 600 and -200 UU/s.
class MovingLine : public testing::Test {
 protected:
  [[nodiscard]] Result<LineCourse> continued(const std::vector<std::int32_t>& targets) const {
    return continued_course(course, axes, targets, units);
  }

  /// @return why the axes cannot continue to `targets`.
  [[nodiscard]] std::string refusal(const std::vector<std::int32_t>& targets) const {
    const auto taken = continued(targets);
    return taken ? "taken" : taken.outcome().message();
  }

  std::optional<LineCourse> course{LineCourse{{100, 200}, {9'100, -2'800}}};
  std::vector<AxisSnapshot> axes{moving_axis(1, 4'600, 600), moving_axis(2, -1'300, -200)};
  std::vector<Unit> units{{}, {.kind = UnitKind::linear, .name = "mm", .size = 1'000.0}};
};

TEST_F(MovingLine, GoesOnStopsBeforeItsEndAndTurnsBack) {
  const auto further = continued({18'100, -5'800});
  ASSERT_TRUE(further) << further.outcome().message();
  EXPECT_THAT(further->farthest, ElementsAre(18'100, -5'800));
  EXPECT_THAT(further->origin, ElementsAre(100, 200));
  // The longer of two lines gives the direction more precisely.
  const auto shorter = continued({6'100, -1'800});
  ASSERT_TRUE(shorter) << shorter.outcome().message();
  EXPECT_THAT(shorter->farthest, ElementsAre(9'100, -2'800));
  const auto back = continued({-17'900, 6'200});
  ASSERT_TRUE(back) << back.outcome().message();
  EXPECT_THAT(back->farthest, ElementsAre(-17'900, 6'200));
  EXPECT_THAT(ways_along(*back), ElementsAre(18'000.0, 6'000.0));
}

TEST_F(MovingLine, TakesATargetThatIsRounded) {
  // 6000 of 9000 UU correspond to -2000 of -3000 UU, and rounding may change a target by one.
  EXPECT_TRUE(continued({6'100, -1'801}));
  EXPECT_THAT(
      refusal({6'100, -1'802}),
      HasSubstr("axis 1.2: its target (607Ah) is -1802 UU (-1.802 mm), but the present line "
                "needs -1800 UU (-1.800 mm), give or take 1 UU (0.001 mm): a line starts from rest "
                "or continues the present one"));
  // Twice the way, twice the rounding.
  EXPECT_TRUE(continued({18'100, -5'802}));
  EXPECT_THAT(refusal({18'100, -5'803}), HasSubstr("axis 1.2: its target (607Ah) is -5803 UU"));
}

TEST_F(MovingLine, NamesTheAxisThatMovesOffTheLine) {
  axes[1] = moving_axis(2, -1'300, -202);
  EXPECT_THAT(refusal({18'100, -5'800}),
              HasSubstr("axis 1.2: its velocity demand (606Bh) is -202 UU/s (-0.202 mm/s), but "
                        "the present line needs -200 UU/s (-0.200 mm/s), give or "
                        "take 1 UU/s (0.001 mm/s)"));
  axes[1] = moving_axis(2, -1'304, -200);
  EXPECT_THAT(refusal({18'100, -5'800}),
              HasSubstr("axis 1.2: its position demand (6062h) is -1304 UU (-1.304 mm), but the "
                        "present line needs -1300 UU (-1.300 mm), give or take 3 UU "
                        "(0.003 mm)"));
  axes[1] = moving_axis(2, -1'303, -201);
  EXPECT_EQ(refusal({18'100, -5'800}), "taken") << "by the rounding of both";
}

TEST_F(MovingLine, NeedsALineInHand) {
  course.reset();
  axes[0] = moving_axis(1, 4'600, 0);
  EXPECT_THAT(
      refusal({18'100, -5'800}),
      HasSubstr("axis 1.2 is still moving: its velocity demand (606Bh) is -200 UU/s (-0.200 mm/s), "
                "but must be 0 since this group has no line to continue"));
}

TEST_F(MovingLine, GivesAnAxisWithoutAWayOneUnit) {
  EXPECT_THAT(ways_along({{0, 5}, {-700, 5}}), ElementsAre(700.0, 1.0));
}

}  // namespace
}  // namespace vdrive::client

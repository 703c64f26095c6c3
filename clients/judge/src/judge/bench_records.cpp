// SPDX-License-Identifier: Apache-2.0
#include "judge/bench_records.hpp"

#include "vdrive/dictionary/dictionary.hpp"

#include <string>

namespace vdrive::judge {

bool is_test_input(ObjectAddress object) {
  const auto row = find_object(object);
  return row && has_role(*row, Role::test_input);
}

Shown shown_by(const AxisStatus& status) noexcept {
  return {.members = ShownMember::kStatusword | ShownMember::kMode | ShownMember::kPosition |
                     ShownMember::kDemand | ShownMember::kFollowingError | ShownMember::kTorque |
                     ShownMember::kErrorCode,
          .statusword = status.ds402_statusword,
          .error_code = status.error_code,
          .torque = status.torque_actual_value,
          .position = status.load_position_actual_value,
          .demand = status.position_demand_value,
          .following_error = status.load_position_error_value,
          .mode = status.op_mode_actual};
}

AxisName axes_of_bench(std::uint32_t bench) {
  return [bench](std::uint32_t axis) {
    return "axis " + std::to_string(bench) + "." + std::to_string(axis);
  };
}

}  // namespace vdrive::judge

// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"

namespace vdrive::tool {
namespace {

bool is_enabled(const client::AxisSnapshot& axis) {
  return axis.state() == PowerState::operation_enabled;
}

constexpr AxisAction kEnableAction{.name = "enable",
                                   .together = client::EachCommand::enable,
                                   .gains_control = true,
                                   .is_done = is_enabled};

}  // namespace

extern const CommandRow kEnable = action_row<kEnableAction>(
    CommandGroup::power, "Go through the power states to Operation enabled", "enable 1.1");

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"

namespace vdrive::tool {
namespace {

constexpr AxisAction kPowerCycleAction{.name = "power-cycle",
                                       .together = client::EachCommand::power_cycle};

}  // namespace

extern const CommandRow kPowerCycle = action_row<kPowerCycleAction>(
    CommandGroup::power, "Switch the axis off and on again", "power-cycle 1.1");

}  // namespace vdrive::tool

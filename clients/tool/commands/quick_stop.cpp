// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"

namespace vdrive::tool {
namespace {

constexpr AxisAction kQuickStopAction{.name = "quick-stop",
                                      .waits = Waits::unless_declined,
                                      .together = client::EachCommand::quick_stop,
                                      .is_done = has_come_to_rest};

}  // namespace

extern const CommandRow kQuickStop = action_row<kQuickStopAction>(
    CommandGroup::power, "Quick stop (0x02), wait for standstill", "quick-stop 1.1");

}  // namespace vdrive::tool

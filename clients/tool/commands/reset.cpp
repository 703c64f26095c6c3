// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"

namespace vdrive::tool {
namespace {

bool has_no_fault(const client::AxisSnapshot& axis) {
  return !is_fault(axis.state());
}

constexpr AxisAction kResetAction{.name = "reset",
                                  .together = client::EachCommand::reset_fault,
                                  .names_next_step = false,
                                  .is_done = has_no_fault};

}  // namespace

extern const CommandRow kReset = action_row<kResetAction>(
    CommandGroup::power, "Reset a fault (rising edge of bit 7)", "reset 1.1");

}  // namespace vdrive::tool

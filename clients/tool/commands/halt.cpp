// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"

namespace vdrive::tool {
namespace {

constexpr AxisAction kHaltAction{.name = "halt",
                                 .waits = Waits::on_request,
                                 .together = client::EachCommand::halt,
                                 .is_done = has_come_to_rest};

}  // namespace

extern const CommandRow kHalt = action_row<kHaltAction>(
    CommandGroup::motion, "Brake to standstill, keep the set-point (0x010F)", "halt 1.1");

}  // namespace vdrive::tool

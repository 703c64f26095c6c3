// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"

namespace vdrive::tool {
namespace {

bool is_disabled(const client::AxisSnapshot& axis) {
  return axis.state() != PowerState::operation_enabled;
}

constexpr AxisAction kDisableAction{
    .name = "disable", .together = client::EachCommand::disable, .is_done = is_disabled};

}  // namespace

extern const CommandRow kDisable = action_row<kDisableAction>(
    CommandGroup::power, "Shut down (0x06): to Ready to switch on", "disable 1.1");

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"

namespace vdrive::tool {
namespace {

constexpr AxisAction kResumeAction{.name = "resume",
                                   .waits = Waits::on_request,
                                   .together = client::EachCommand::resume,
                                   .is_done = has_come_to_rest};

}  // namespace

extern const CommandRow kResume = action_row<kResumeAction>(
    CommandGroup::motion, "End a halt and continue the set-point (0x0F)", "resume 1.1");

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"
#include "execution/parameter_memory.hpp"

namespace vdrive::tool {
namespace {

/// What a disk keeps waits for no drive time.
client::Outcome restore_parameters(client::Axis& axis) {
  return axis.restore_defaults();
}

Deed restored(const client::Axis& axis) {
  return {.text = "no stored parameters (1011h:01) are left in " + memory_text(axis) +
                  "; the configured values are in force after the next power cycle",
          .facts = memory_json(axis, "1011h:01")};
}

constexpr AxisAction kRestoreAction{
    .name = "restore", .each = restore_parameters, .deed = restored};

}  // namespace

extern const CommandRow kRestore = action_row<kRestoreAction>(
    CommandGroup::parameters,
    "Remove stored parameters; defaults are in force after the next power cycle", "restore 1.1");

}  // namespace vdrive::tool

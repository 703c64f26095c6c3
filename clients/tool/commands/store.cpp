// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"
#include "execution/parameter_memory.hpp"

namespace vdrive::tool {
namespace {

/// What a disk keeps waits for no drive time.
client::Outcome store_parameters(client::Axis& axis) {
  return axis.store();
}

Deed stored(const client::Axis& axis) {
  return {.text = "stored " + parameters_text() + " in " + memory_text(axis),
          .facts = memory_json(axis)};
}

constexpr AxisAction kStoreAction{.name = "store", .each = store_parameters, .deed = stored};

}  // namespace

extern const CommandRow kStore = action_row<kStoreAction>(
    CommandGroup::parameters, "Store the parameters for every later power-up", "store 1.1");

}  // namespace vdrive::tool

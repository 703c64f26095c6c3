// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"
#include "execution/parameter_memory.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <string>
#include <utility>

namespace vdrive::tool {
namespace {

/// What a disk keeps waits for no drive time.
client::Outcome store_parameters(client::Axis& axis) {
  return axis.store();
}

Deed stored(const client::Axis& axis) {
  Json facts{{"objects", kStoredRows.size()}};
  facts.update(memory_json(axis, "1010h:01"));
  return {.text = "stored " + std::to_string(kStoredRows.size()) + " parameters (1010h:01) in " +
                  memory_text(axis),
          .facts = std::move(facts)};
}

constexpr AxisAction kStoreAction{.name = "store", .each = store_parameters, .deed = stored};

}  // namespace

extern const CommandRow kStore = action_row<kStoreAction>(
    CommandGroup::parameters, "Store the parameters for every later power-up", "store 1.1");

}  // namespace vdrive::tool

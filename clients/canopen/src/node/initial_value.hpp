// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/node_object.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>

namespace vdrive::canopen {

/// @param node_id is added where the default has it (`NodeObject::has_node_id`)
/// @return the default of a communication object; 0 when the dictionary does not have the object.
[[nodiscard]] inline std::uint32_t initial_value(ObjectAddress object, std::uint8_t node_id = 0) {
  const NodeObject* const found = find_node_object(object);
  return found == nullptr ? 0U : static_cast<std::uint32_t>(default_of(*found, node_id));
}

}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/object_types.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <span>

namespace vdrive::canopen {

/// Every object of a node, by index and sub-index. The drive's rows are made of kObjectTable, the
/// others of the one table of communication objects (communication_objects.hpp). Made once; the
/// texts are static.
[[nodiscard]] std::span<const NodeObject> node_objects();

/// @return the object at `address`; nothing when there is none.
[[nodiscard]] const NodeObject* find_node_object(ObjectAddress address);

/// @return object_does_not_exist when no object has this index, subindex_does_not_exist when the
///         index has no such sub-index, else none.
[[nodiscard]] AbortCode check_node_address(ObjectAddress address);

/// @return the default of a communication object in a node, its node id added where it has one.
[[nodiscard]] std::int64_t default_of(const NodeObject& object, std::uint8_t node_id) noexcept;

}  // namespace vdrive::canopen

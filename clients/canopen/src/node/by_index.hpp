// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace vdrive::canopen {

/// @param objects rows with an `address`, sorted by it
/// @return the rows of each index.
template <typename Object>
[[nodiscard]] std::vector<std::span<const Object>> by_index(std::span<const Object> objects) {
  std::vector<std::span<const Object>> indices;
  while (!objects.empty()) {
    const auto next = std::ranges::find_if(objects, [&objects](const Object& object) {
      return object.address.index != objects.front().address.index;
    });
    const auto count = static_cast<std::size_t>(next - objects.begin());
    indices.push_back(objects.first(count));
    objects = objects.subspan(count);
  }
  return indices;
}

}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
#include "node/set_points.hpp"

#include "vdrive/dictionary/object_table.hpp"

namespace vdrive::canopen {

void SetPoints::put(const DriveValue& value) {
  using namespace vdrive::literals;
  constexpr ObjectAddress kControlword = kObjectRows["ds402_controlword"_object].address;
  std::erase_if(values_, [&value](const DriveValue& earlier) {
    return earlier.object == value.object;
  });
  const bool ends_with_controlword = !values_.empty() && values_.back().object == kControlword;
  values_.insert(ends_with_controlword ? values_.end() - 1 : values_.end(), value);
}

}  // namespace vdrive::canopen

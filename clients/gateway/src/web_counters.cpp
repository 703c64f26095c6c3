// SPDX-License-Identifier: Apache-2.0
#include "web_counters.hpp"

#include "vdrive/assert.hpp"

namespace vdrive::gateway {

std::string_view to_string(CutOff cut_off) noexcept {
  static constexpr std::array<std::string_view, kCutOffs> kNames{"silent", "unread", "flood"};
  const auto place = static_cast<std::size_t>(cut_off);
  ensure(place < kNames.size(), "every cut-off has a name");
  return kNames[place];
}

}  // namespace vdrive::gateway

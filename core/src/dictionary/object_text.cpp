// SPDX-License-Identifier: Apache-2.0
#include "vdrive/dictionary/object_text.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

namespace vdrive {

std::string index_text(std::uint16_t index) {
  return hex(index, 4).substr(2) + "h";
}

std::string object_text(ObjectAddress object) {
  const auto row = find_object(object);
  std::string text(row ? describe(*row).variable_name : "object");
  text.append(" (").append(index_text(object.index));
  if (object.subindex != 0) text.append(":").append(std::to_string(object.subindex));
  return text.append(")");
}

}  // namespace vdrive

// SPDX-License-Identifier: Apache-2.0
#include "bank/parameter_memory.hpp"

#include "drive/objects.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <cstddef>

namespace vdrive {

AbortCode check_stored(ObjectAddress object, std::int64_t value) noexcept {
  const auto row = find_row(object);
  if (!row) return check_address(object);
  // Whether the axis is a modulo axis depends on its other stored values: `load_into` checks that.
  return kObjectRows[*row].storage == Storage::flash ? check_value_on_modulo_axis(*row, value)
                                                     : AbortCode::cannot_store_or_transfer;
}

AbortCode ParameterMemory::keep(ObjectAddress object, std::int64_t value) noexcept {
  const AbortCode code = check_stored(object, value);
  if (code != AbortCode::none) return code;
  const auto place = std::ranges::lower_bound(kStoredRows, *find_row(object));
  const auto position = static_cast<std::size_t>(place - kStoredRows.begin());
  values[position] = value;
  present[position] = true;
  return code;
}

/// An object whose stored value this version refuses, for example because a limit became narrower,
/// keeps its initial value.
void ParameterMemory::load_into(Drive& drive) const noexcept {
  for (std::size_t position = 0; position < kStoredCount; ++position) {
    if (present[position]) {
      static_cast<void>(write_object(drive, kStoredRows[position], values[position]));
    }
  }
}

}  // namespace vdrive

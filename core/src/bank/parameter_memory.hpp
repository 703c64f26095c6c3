// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>
#include <bitset>
#include <cstdint>
#include <type_traits>

namespace vdrive {

/// What 1010h stored of an axis. Not every object need be there: an earlier program may have stored
/// it, whose dictionary had fewer.
struct ParameterMemory {
  std::bitset<kStoredCount> present;  // bit n: values[n] is of row kStoredRows[n]
  std::array<std::int64_t, kStoredCount> values{};

  /// @return that of AxisBank::check_stored; where it is not none nothing has changed.
  AbortCode keep(ObjectAddress object, std::int64_t value) noexcept;

  /// Writes what is stored, as at a power-up.
  void load_into(Drive& drive) const noexcept;
};

static_assert(std::is_trivially_copyable_v<ParameterMemory>);

/// @return AbortCode::none when 1010h could store this value of this object.
[[nodiscard]] AbortCode check_stored(ObjectAddress object, std::int64_t value) noexcept;

}  // namespace vdrive

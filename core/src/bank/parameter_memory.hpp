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

/// The values that 1010h stored for an axis. Some objects may be missing: an earlier version with a
/// smaller dictionary may have stored them.
struct ParameterMemory {
  std::bitset<kStoredCount> present;  // bit n: values[n] is set and belongs to row kStoredRows[n]
  std::array<std::int64_t, kStoredCount> values{};

  /// @return the result of AxisBank::check_stored; nothing changes unless it is AbortCode::none.
  AbortCode keep(ObjectAddress object, std::int64_t value) noexcept;

  /// Writes the stored values, as at power-up.
  void load_into(Drive& drive) const noexcept;
};

static_assert(std::is_trivially_copyable_v<ParameterMemory>);

/// @return AbortCode::none when 1010h could store this value of this object.
[[nodiscard]] AbortCode check_stored(ObjectAddress object, std::int64_t value) noexcept;

}  // namespace vdrive

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::client {

/// A tick of a run of a service and how many ticks its number has jumped over until then, as status
/// frames and states show it.
struct RunTime {
  std::uint64_t tick = 0;
  std::uint32_t skipped_ticks = 0;  ///< modulo 2^32
};

/// @return how many ticks were run from `from` to `to`, which is not earlier. Exact below 2^32 of
///         them: the number may jump by more.
[[nodiscard]] constexpr std::uint64_t ticks_run(const RunTime& from, const RunTime& to) noexcept {
  const auto passed = static_cast<std::uint32_t>(to.tick - from.tick);
  return static_cast<std::uint32_t>(passed - (to.skipped_ticks - from.skipped_ticks));
}

/// @return how many ticks the number jumped over meanwhile.
[[nodiscard]] constexpr std::uint64_t ticks_skipped(const RunTime& from,
                                                    const RunTime& to) noexcept {
  return to.tick - from.tick - ticks_run(from, to);
}

}  // namespace vdrive::client

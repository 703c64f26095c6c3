// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// What the reply to REQUEST_READ_WRITES holds: a list of writes, oldest first, as results of
/// objects. An entry whose index is 0 is no write but a mark, which tells of what follows it or
/// what happened.
namespace vdrive::wire {

/// The sub-index of a mark.
enum class WrittenMark : std::uint8_t {
  tick = 1,         ///< value: the last completed tick before the writes that follow
  by_request = 2,   ///< value: the session that makes them, acyclically; 0 = one without a number
  by_frame = 3,     ///< value: the session that makes them, by command frames
  by_bench = 4,     ///< the bench makes them, because it ends
  lost = 5,         ///< value: how many older entries are no longer kept
  restored = 6,     ///< all axes got the state of a snapshot
  power_cycle = 7,  ///< of the axis of this mark
};

}  // namespace vdrive::wire

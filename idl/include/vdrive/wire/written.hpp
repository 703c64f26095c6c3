// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// The contents of the replies to REQUEST_READ_WRITES and REQUEST_READ_WINDOW: a list of writes,
/// oldest first, each as an ObjectResult. An entry with index 0 is not a write but a mark, which
/// describes the entries after it or an event.
namespace vdrive::wire {

/// The sub-index of a mark.
enum class WrittenMark : std::uint8_t {
  tick = 1,         ///< value: the last completed tick before the writes that follow
  by_request = 2,   ///< value: the session that wrote by requests; 0 = a writer without a session
  by_frame = 3,     ///< value: the session that wrote with command frames
  by_bench = 4,     ///< the bench wrote, because it is shutting down
  lost = 5,         ///< value: number of older entries that are no longer kept
  restored = 6,     ///< all axes took the state of a snapshot
  power_cycle = 7,  ///< the axis of this mark was power-cycled

  // Only in windows, with the causes of REQUEST_NEXT_WINDOW:

  connection_loss = 8,  ///< the master of the axis of this mark stopped sending
  event = 9,            ///< value: EventKind, abort_code: its code; axis 0 = the bench
  of_session = 10,      ///< value: the session of the event or cause that follows
  began = 11,           ///< the entries that follow are the values of objects at the start
  jumped = 12,          ///< likewise, after a jump of the tick number
  resumed = 13,         ///< likewise, after ticks that were not recorded
  fault = 14,           ///< a cause; value: tick, abort_code: 603Fh
  master_lost = 15,     ///< likewise, for the axes of the session
  stopped = 16,         ///< likewise, by a session that does not own the axis
  asked = 17,           ///< likewise, requested by the session
  more_causes = 18,     ///< value: number of further causes
  open = 19,            ///< the window is still being recorded; value: the tick at which it ends
};

}  // namespace vdrive::wire

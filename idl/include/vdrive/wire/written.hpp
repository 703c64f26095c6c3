// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// What the replies to REQUEST_READ_WRITES and REQUEST_READ_WINDOW hold: a list of writes, oldest
/// first, as results of objects. An entry whose index is 0 is no write but a mark, which tells of
/// what follows it or what happened.
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

  // Of windows alone, as the causes of REQUEST_NEXT_WINDOW:

  connection_loss = 8,  ///< of the axis of this mark: its master fell silent
  event = 9,            ///< value: EventKind, abort_code: its code; axis 0 = the bench
  of_session = 10,      ///< value: the session that the event or the cause after it names
  began = 11,           ///< what follows are no writes but the values of objects at the beginning
  jumped = 12,          ///< likewise, after the number of the tick has jumped
  resumed = 13,         ///< likewise, after a time that was not recorded
  fault = 14,           ///< a cause; value: tick, abort_code: 603Fh
  master_lost = 15,     ///< likewise, of the axes of the session
  stopped = 16,         ///< likewise, by the session, which does not own the axis
  asked = 17,           ///< likewise, by the session
  more_causes = 18,     ///< value: how many have found no room
  open = 19,            ///< the window is still being recorded; value: with which tick it will end
};

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/lazy_slots.hpp"
#include "base/stored_list.hpp"
#include "seam/queues.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdrive::service {

/// Command frames that wait for their tick, in order of tick, then of arrival. Fixed size; commands
/// move in and out by swapping, so that nothing allocates. Room that was never used costs no
/// memory.
class PendingFrames {
 public:
  static constexpr std::size_t kCapacity = Outbox::kPendingFrames;

  PendingFrames();

  /// Takes the content of `frame`, to be due at `tick`. @return false when there is no room.
  [[nodiscard]] bool insert(std::uint64_t tick, msg::CommandFrame& frame) noexcept;

  /// Moves the first frame that is due at `tick` into `frame`. @return false when none is.
  [[nodiscard]] bool take_due(std::uint64_t tick, msg::CommandFrame& frame) noexcept;

  /// Removes the frames for which `condition(head, commands)` holds and shows the head of each to
  /// `dropped(head)`: the frame without its commands.
  template <typename Condition, typename Dropped>
  void drop_if(Condition condition, Dropped dropped) {
    for (std::size_t position = 0; position < order_.size();) {
      const auto& slot = slots_[order_[position].slot];
      if (condition(slot.head, slot.commands.items())) {
        dropped(slot.head);
        remove(position);
      } else {
        ++position;
      }
    }
  }

  [[nodiscard]] bool contains(std::uint64_t session, std::uint64_t sequence) const noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return order_.size(); }

 private:
  struct Slot {
    msg::CommandFrame head;  ///< without its commands
    StoredList<msg::AxisCommand, msg::MAX_AXES_PER_FRAME> commands;
  };

  struct Place {
    std::uint64_t tick;
    std::uint16_t slot;
  };

  static void exchange(Slot& slot, msg::CommandFrame& frame);
  void remove(std::size_t position) noexcept;

  LazySlots<Slot> slots_;
  std::vector<Place> order_;
  std::vector<std::uint16_t> free_;
};

}  // namespace vdrive::service

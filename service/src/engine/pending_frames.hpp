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

/// The command frames that wait for their tick, ordered by tick, then by arrival. Fixed size;
/// commands are swapped in and out, so nothing allocates. Slots never used cost no memory.
class PendingFrames {
 public:
  static constexpr std::size_t kCapacity = Outbox::kPendingFrames;

  PendingFrames();

  /// Takes the content of `frame`, which is due at `tick`. @return false if there is no room.
  [[nodiscard]] bool insert(std::uint64_t tick, msg::CommandFrame& frame) noexcept;

  /// Moves the first frame that is due at `tick` to `frame`. @return false if none is due.
  [[nodiscard]] bool take_due(std::uint64_t tick, msg::CommandFrame& frame) noexcept;

  /// Removes the frames for which `condition(head, commands)` holds, and calls `dropped(head)` for
  /// each. The head is the frame without its commands.
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "journal/black_box.hpp"
#include "vdrive/axis_bank.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::service {

/// Recomputes a window of the black box for some axes, and steps only the groups of the bank that
/// contain them. The caller holds the window while it uses this object, which may run in a
/// different thread than the box.
class WindowReplay {
 public:
  /// The kind of item that next() has reached.
  enum class Item : std::uint8_t {
    state,  ///< the window begins here, or continues with a different state: `cause()`
    tick,   ///< the axes have completed a tick
    entry,  ///< a change to one of the axes by `author()`, or an event: `entry()`
    end,
  };

  /// @throws what AxisBank throws
  explicit WindowReplay(const Configuration& configuration);

  /// Goes to the beginning of a window.
  /// @param axes indexes on the bench
  void start(const BlackBox& box, const Window& window, std::span<const std::size_t> axes);

  /// Advances to the next item.
  Item next();

  /// @return the last completed tick at the last item.
  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

  [[nodiscard]] BlackBox::Segment::Cause cause() const noexcept { return cause_; }

  [[nodiscard]] const BoxEntry& entry() const noexcept { return entry_; }

  [[nodiscard]] const JournalAuthor& author() const noexcept { return author_; }

  [[nodiscard]] const AxisBank& bank() const noexcept { return bank_; }

 private:
  [[nodiscard]] bool open_segment();
  [[nodiscard]] std::optional<Item> complete_tick();
  [[nodiscard]] bool take(const BoxEntry& entry);
  void step();
  [[nodiscard]] bool is_of_interest(const BoxEntry& entry) const;
  void apply(const BoxEntry& entry);

  AxisBank bank_;
  const BlackBox* box_ = nullptr;
  Window window_;
  std::vector<std::uint16_t> numbers_;  ///< by index
  std::vector<bool> is_wanted_;         ///< by index
  std::vector<std::size_t> groups_;
  std::size_t next_segment_ = 0;
  std::optional<BlackBox::Entries> entries_;
  std::uint64_t ticks_left_ = 0;  ///< of the present ticks entry
  std::uint64_t tick_ = 0;
  BlackBox::Segment::Cause cause_{};
  BoxEntry entry_;
  JournalAuthor author_;
  bool is_shown_ = false;  ///< the window has begun
};

}  // namespace vdrive::service

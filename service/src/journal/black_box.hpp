// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"
#include "base/lazy_slots.hpp"
#include "base/pages.hpp"
#include "base/ring.hpp"
#include "base/window.hpp"
#include "configuration/configuration.hpp"
#include "journal/journal_file.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive_messages.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::service {

/// Something that the black box has recorded, in the order in which it happened.
struct BoxEntry {
  enum class Kind : std::uint8_t {
    ticks,    ///< value: how many were completed one after the other
    change,   ///< of `change`: axis, address, value
    refusal,  ///< a write that was refused: axis, address, value; code: why
    author,   ///< whose the entries after this one are. means; value: session
    event,    ///< axis; code; address.index: msg::EventKind; value: session
  };

  std::int64_t value = 0;
  std::uint32_t code = 0;
  std::uint16_t axis = 0;  ///< index on the bench; of an event: number, 0 = the bench
  ObjectAddress address{};
  Kind kind = Kind::ticks;
  JournalChange::Kind change = JournalChange::Kind::write;
  JournalAuthor::Means means = JournalAuthor::Means::none;
};

/// What a bench did in the last minutes, in bounded memory and without a journal: a snapshot every
/// few seconds of drive time, and what was done to the axes since. The core is a function, so each
/// tick in between can be computed again (WindowReplay). What happened around a fault is kept
/// longer, as a window.
///
/// Belongs to the thread that steps the bank. Once warm it allocates nothing and takes no lock.
/// Another thread may read the segments of a window between `hold` and `let_go`.
class BlackBox {
 public:
  /// What was recorded from a snapshot on.
  struct Segment {
    enum class Cause : std::uint8_t {
      started,    ///< recording began, or begins again after a loss
      continued,  ///< the state is that after the last tick of the segment before
      restored,   ///< somebody restored a snapshot
      jumped,     ///< the number of the tick jumped
    };

    Cause cause = Cause::started;
    std::uint64_t tick = 0;   ///< of the snapshot
    std::uint64_t ticks = 0;  ///< completed since
    std::span<std::byte> state;
    std::uint32_t first_block = 0;
    std::uint32_t last_block = 0;
    std::uint64_t entries = 0;
    std::atomic<std::uint32_t> holders{0};  ///< 0: its room may be used again
    bool has_blocks = false;
  };

  /// Where black_box_memory_mib has no room for four snapshots nothing is recorded.
  BlackBox(const Configuration& configuration, const AxisBank& bank);

  [[nodiscard]] bool is_on() const noexcept { return slots_ > 0; }

  /// Of a snapshot [bytes].
  [[nodiscard]] std::size_t state_size() const noexcept { return segments_[0].state.size(); }

  /// Before the first change, or when the number of the first tick is known. The calls that record
  /// do nothing before it.
  void begin(const AxisBank& bank, std::uint64_t tick);

  // NOLINTBEGIN(bugprone-exception-escape): all that they fill has its room from the start
  void record(const JournalEntry& entry, const JournalAuthor& author) noexcept;
  /// All axes got the state of a snapshot.
  void record_restore(const AxisBank& bank, std::uint64_t tick) noexcept;
  void record_tick(const AxisBank& bank, std::uint64_t tick) noexcept;
  /// A fault, a lost master and a stop by somebody freeze a window.
  void record_event(const EventRecord& event) noexcept;
  // NOLINTEND(bugprone-exception-escape)

  /// Freezes a window around the last tick, or adds the cause to the one that is still being
  /// recorded.
  /// @return its number, 0 = nothing is recorded
  std::uint64_t freeze(const WindowCause& cause);

  /// The window that is still being recorded ends with the last tick.
  void end_window(const AxisBank& bank);

  /// @return the window with the least number above `number`, or nullptr.
  [[nodiscard]] const Window* next_window(std::uint64_t number) const noexcept;

  [[nodiscard]] bool is_open(const Window& window) const noexcept { return &window == &open_; }

  /// @return the tick with which the window that is still being recorded ends.
  [[nodiscard]] std::uint64_t end_of_open() const noexcept { return open_until_; }

  /// From now on a window is handed over when it is frozen, and again as soon as it is opened.
  void hand_over_windows() noexcept { hands_over_ = true; }

  /// For one other thread: the next window to be kept elsewhere, or nullptr. It is held until
  /// `pop_handed_over`.
  [[nodiscard]] const Window* handed_over() noexcept { return handed_over_.front(); }

  void pop_handed_over() noexcept;

  /// A segment that another run has recorded.
  struct KeptSegment {
    Segment::Cause cause = Segment::Cause::started;
    std::uint64_t tick = 0;
    std::uint64_t ticks = 0;
    std::span<const std::byte> state;
    std::span<const BoxEntry> entries;
  };

  /// Before the first step: keeps a window of an earlier run under its number, newest windows
  /// first.
  /// @return whether there is room beside those that are there
  bool adopt(const Window& window, std::span<const KeptSegment> segments);

  /// How many pages of windows wait to be computed. Any thread.
  std::atomic<std::uint32_t> pages_waiting{0};

  /// The segments of the window stay as they are until they are let go, by any thread.
  void hold(const Window& window) noexcept;
  void let_go(const Window& window) noexcept;

  [[nodiscard]] const Segment& segment(std::uint32_t slot) const noexcept {
    return segments_[slot];
  }

  /// The entries of a segment that is held, one after the other.
  class Entries {
   public:
    Entries(const BlackBox& box, const Segment& segment) noexcept
        : box_(&box), block_(segment.first_block), left_(segment.entries) {}

    /// @return the next one, or nullptr at the end.
    [[nodiscard]] const BoxEntry* next() noexcept;

   private:
    const BlackBox* box_;
    std::uint32_t block_;
    std::uint64_t left_;
    std::size_t place_ = 0;
  };

 private:
  static constexpr std::size_t kEntriesOfBlock = 1'024;
  static constexpr std::uint32_t kNone = 0xFFFF'FFFF;

  struct Block {
    std::uint32_t next = kNone;
    std::array<BoxEntry, kEntriesOfBlock> entries{};
  };

  [[nodiscard]] Segment& current() noexcept { return segments_[recent_.back()]; }

  void begin_segment(const AxisBank& bank, std::uint64_t tick, Segment::Cause cause);
  [[nodiscard]] bool is_complete(const Segment& segment) const noexcept;
  void put(const BoxEntry& entry);
  [[nodiscard]] BoxEntry* append(Segment& segment, const BoxEntry& entry);
  [[nodiscard]] bool open(std::uint32_t slot, std::uint64_t tick, Segment::Cause cause);
  void collect_segments(Window& window) const;
  [[nodiscard]] bool has_room_for(std::span<const KeptSegment> segments) const noexcept;
  void hand_over(const Window& window) noexcept;
  void hand_over_open(const AxisBank& bank);
  [[nodiscard]] std::optional<std::uint32_t> take_slot();
  [[nodiscard]] std::optional<std::uint32_t> take_block();
  void recycle_blocks() noexcept;
  [[nodiscard]] bool forget_something() noexcept;
  [[nodiscard]] bool drop_window() noexcept;

  std::uint64_t segment_ticks_;
  std::uint64_t ticks_before_;
  std::uint64_t ticks_after_;
  std::size_t slots_;
  Pages states_;
  LazySlots<Block> blocks_;
  std::unique_ptr<Segment[]> segments_;  // NOLINT(*-avoid-c-arrays): atomics do not move
  std::vector<std::uint32_t> recent_;    ///< slots, oldest first; the last one is being filled
  std::uint32_t free_block_ = kNone;     ///< the first of a chain
  std::size_t blocks_made_ = 0;
  bool is_recording_ = false;
  std::uint64_t tick_ = 0;
  std::optional<JournalAuthor> author_;  ///< of the last entry
  BoxEntry* ticks_entry_ = nullptr;      ///< the last entry, where it counts ticks
  std::vector<Window> windows_;          ///< frozen, by number
  Window open_;                          ///< still recorded; number 0 = none
  std::uint64_t open_until_ = 0;
  std::uint64_t last_number_ = 0;
  bool hands_over_ = false;
  bool is_open_handed_over_ = false;
  Ring<Window> handed_over_{kMostWindows};
};

}  // namespace vdrive::service

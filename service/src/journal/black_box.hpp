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

/// One entry of the black box. Entries are kept in the order in which things happened.
struct BoxEntry {
  enum class Kind : std::uint8_t {
    ticks,    ///< value: the number of consecutive ticks that were completed
    change,   ///< kind in `change`; axis, address, value
    refusal,  ///< a refused write: axis, address, value; code: the reason
    author,   ///< the author of the entries that follow: means; value: session
    event,    ///< axis; code; address.index: msg::EventKind; value: session
  };

  std::int64_t value = 0;
  std::uint32_t code = 0;
  std::uint16_t axis = 0;  ///< index on the bench; for an event, the axis number, 0 = the bench
  ObjectAddress address{};
  Kind kind = Kind::ticks;
  JournalChange::Kind change = JournalChange::Kind::write;
  JournalAuthor::Means means = JournalAuthor::Means::none;
};

/// Records the last minutes of a bench in bounded memory and without a journal: a snapshot every
/// few seconds of drive time, and all changes to the axes since. The core is deterministic, so each
/// tick in between can be recomputed (WindowReplay). The ticks around a fault are kept longer, as a
/// window.
///
/// Belongs to the thread that steps the bank. It takes no lock, and allocates nothing after its
/// construction. Another thread may read the segments of a window between `hold` and `let_go`.
class BlackBox {
 public:
  /// A snapshot and everything recorded since, up to the next snapshot.
  struct Segment {
    enum class Cause : std::uint8_t {
      started,    ///< recording began, or resumed after a loss
      continued,  ///< the state is the one after the last tick of the previous segment
      restored,   ///< a client restored a snapshot
      jumped,     ///< the tick number jumped
    };

    Cause cause = Cause::started;
    std::uint64_t tick = 0;   ///< of the snapshot
    std::uint64_t ticks = 0;  ///< completed since
    std::span<std::byte> state;
    std::uint32_t first_block = 0;
    std::uint32_t last_block = 0;
    std::uint64_t entries = 0;
    std::atomic<std::uint32_t> holders{0};  ///< 0: its memory may be reused
    bool has_blocks = false;
  };

  /// Records nothing if black_box_memory_mib is too small for four snapshots.
  BlackBox(const Configuration& configuration, const AxisBank& bank);

  [[nodiscard]] bool is_on() const noexcept { return slots_ > 0; }

  /// @return the size of a snapshot [bytes].
  [[nodiscard]] std::size_t state_size() const noexcept { return segments_[0].state.size(); }

  /// Starts recording; until then the record functions do nothing. To be called before the first
  /// change, and again when the number of the first tick becomes known.
  void begin(const AxisBank& bank, std::uint64_t tick);

  // NOLINTBEGIN(bugprone-exception-escape): everything they fill is reserved at the start
  void record(const JournalEntry& entry, const JournalAuthor& author) noexcept;
  /// Records that all axes were set to the state of a snapshot.
  void record_restore(const AxisBank& bank, std::uint64_t tick) noexcept;
  void record_tick(const AxisBank& bank, std::uint64_t tick) noexcept;
  /// A fault, a lost master and a stop by another session freeze a window.
  void record_event(const EventRecord& event) noexcept;
  // NOLINTEND(bugprone-exception-escape)

  /// Freezes a window around the last tick, or adds the cause to the window that is still open.
  /// @return the number of the window, 0 = nothing is being recorded
  std::uint64_t freeze(const WindowCause& cause);

  /// Ends the open window with the last tick.
  void end_window(const AxisBank& bank);

  /// @return the window with the lowest number above `number`, or nullptr.
  [[nodiscard]] const Window* next_window(std::uint64_t number) const noexcept;

  [[nodiscard]] bool is_open(const Window& window) const noexcept { return &window == &open_; }

  /// @return the last tick of the open window.
  [[nodiscard]] std::uint64_t end_of_open() const noexcept { return open_until_; }

  /// From now on each window is handed over twice: one tick after it was opened, and when it ends.
  void hand_over_windows() noexcept { hands_over_ = true; }

  /// For one other thread: the next window to store elsewhere, or nullptr. It is held until
  /// `pop_handed_over`.
  [[nodiscard]] const Window* handed_over() noexcept { return handed_over_.front(); }

  void pop_handed_over() noexcept;

  /// A segment recorded by an earlier run.
  struct KeptSegment {
    Segment::Cause cause = Segment::Cause::started;
    std::uint64_t tick = 0;
    std::uint64_t ticks = 0;
    std::span<const std::byte> state;
    std::span<const BoxEntry> entries;
  };

  /// Keeps a window of an earlier run under its number. Only before the first step, newest windows
  /// first.
  /// @return whether there was room for it
  bool adopt(const Window& window, std::span<const KeptSegment> segments);

  /// The number of window pages that wait to be computed. Any thread.
  std::atomic<std::uint32_t> pages_waiting{0};

  /// Keeps the segments of the window unchanged until `let_go`, which any thread may call.
  void hold(const Window& window) noexcept;
  void let_go(const Window& window) noexcept;

  [[nodiscard]] const Segment& segment(std::uint32_t slot) const noexcept {
    return segments_[slot];
  }

  /// Iterates over the entries of a held segment.
  class Entries {
   public:
    Entries(const BlackBox& box, const Segment& segment) noexcept
        : box_(&box), block_(segment.first_block), left_(segment.entries) {}

    /// @return the next entry, or nullptr at the end.
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
  [[nodiscard]] bool free_oldest() noexcept;
  [[nodiscard]] bool drop_window() noexcept;

  std::uint64_t segment_ticks_;
  std::uint64_t ticks_before_;
  std::uint64_t ticks_after_;
  std::size_t slots_;
  Pages states_;
  LazySlots<Block> blocks_;
  std::unique_ptr<Segment[]> segments_;  // NOLINT(*-avoid-c-arrays): atomics do not move
  std::vector<std::uint32_t> recent_;    ///< slots, oldest first; the last one is being filled
  std::uint32_t free_block_ = kNone;     ///< the first block of the chain of free ones
  std::size_t blocks_made_ = 0;
  bool is_recording_ = false;
  std::uint64_t tick_ = 0;
  std::optional<JournalAuthor> author_;  ///< of the last entry
  BoxEntry* ticks_entry_ = nullptr;      ///< the last entry, if it counts ticks
  std::vector<Window> windows_;          ///< frozen, by number
  Window open_;                          ///< still being recorded; number 0 = none
  std::uint64_t open_until_ = 0;
  std::uint64_t last_number_ = 0;
  bool hands_over_ = false;
  bool is_open_handed_over_ = false;
  Ring<Window> handed_over_{kMostWindows};
};

}  // namespace vdrive::service

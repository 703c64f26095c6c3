// SPDX-License-Identifier: Apache-2.0
#include "journal/black_box.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

constexpr auto kSegmentDuration = 5s;
constexpr auto kBeforeCause = 2s;
constexpr auto kAfterCause = 500ms;
constexpr auto kLongestAfter = 2s;  // when further causes follow
/// The segment being filled, the previous one, and the older ones that a window holds.
constexpr std::size_t kLeastSlots = 4;
constexpr std::size_t kMostSlots = 512;  // 40 minutes
constexpr std::size_t kLeastRecent = 2;
constexpr std::uint64_t kTicksUntilNextTry = 1'000;

std::uint64_t ticks_in(std::chrono::nanoseconds time, std::chrono::microseconds period) {
  return static_cast<std::uint64_t>(time / period);
}

std::size_t bytes_of(const Configuration& configuration) {
  return std::size_t{configuration.black_box_memory_mib} << 20U;
}

/// @return as many slots as fit into three quarters of the memory; the entries need the rest.
std::size_t slots_of(std::size_t memory, std::size_t state_size) {
  const std::size_t slots = std::min(kMostSlots, memory / 4 * 3 / state_size);
  return slots < kLeastSlots ? 0 : slots;
}

BoxEntry box_entry(const JournalChange& change) {
  return {.value = change.value,
          .axis = change.axis,
          .address = change.address,
          .kind = BoxEntry::Kind::change,
          .change = change.kind};
}

BoxEntry box_entry(const JournalRefusal& refusal) {
  return {.value = refusal.value,
          .code = refusal.reason,
          .axis = refusal.axis,
          .address = refusal.address,
          .kind = BoxEntry::Kind::refusal};
}

BoxEntry box_entry(const JournalAuthor& author) {
  return {.value = static_cast<std::int64_t>(author.session),
          .kind = BoxEntry::Kind::author,
          .means = author.means};
}

std::optional<WindowCause::Kind> cause_kind(msg::EventKind event) {
  switch (event) {
    case msg::EventKind::fault:
      return WindowCause::Kind::fault;
    case msg::EventKind::master_lost:
      return WindowCause::Kind::master_lost;
    case msg::EventKind::stopped:
      return WindowCause::Kind::stopped;
    default:
      return std::nullopt;
  }
}

}  // namespace

BlackBox::BlackBox(const Configuration& configuration, const AxisBank& bank)
    : segment_ticks_(ticks_in(kSegmentDuration, configuration.period)),
      ticks_before_(ticks_in(kBeforeCause, configuration.period)),
      ticks_after_(ticks_in(kAfterCause, configuration.period)),
      slots_(slots_of(bytes_of(configuration), bank.snapshot_size())),
      states_(std::max<std::size_t>(slots_ * bank.snapshot_size(), 1)),
      blocks_(slots_ == 0
                  ? 1
                  : (bytes_of(configuration) - slots_ * bank.snapshot_size()) / sizeof(Block)),
      segments_(std::make_unique<Segment[]>(slots_)) {  // NOLINT(*-avoid-c-arrays)
  for (std::size_t slot = 0; slot < slots_; ++slot) {
    segments_[slot].state =
        states_.memory().subspan(slot * bank.snapshot_size(), bank.snapshot_size());
  }
  recent_.reserve(slots_);
  windows_.reserve(kMostWindows);
}

void BlackBox::begin(const AxisBank& bank, std::uint64_t tick) {
  for (const std::uint32_t slot : recent_) {
    segments_[slot].holders.fetch_sub(1, std::memory_order_release);
  }
  recent_.clear();
  if (is_on()) begin_segment(bank, tick, Segment::Cause::started);
}

// NOLINTBEGIN(bugprone-exception-escape): everything they fill is reserved at the start
void BlackBox::record(const JournalEntry& entry, const JournalAuthor& author) noexcept {
  if (!is_recording_) return;
  if (author_ != author) put(box_entry(author));
  author_ = author;
  std::visit(
      [this](const auto& content) {
        put(box_entry(content));
      },
      entry);
}

void BlackBox::record_restore(const AxisBank& bank, std::uint64_t tick) noexcept {
  if (is_recording_) begin_segment(bank, tick, Segment::Cause::restored);
}

void BlackBox::record_tick(const AxisBank& bank, std::uint64_t tick) noexcept {
  if (!is_recording_) {
    if (is_on() && tick % kTicksUntilNextTry == 0) {
      begin_segment(bank, tick, Segment::Cause::started);
    }
    return;
  }
  if (tick != tick_ + 1) return begin_segment(bank, tick, Segment::Cause::jumped);
  tick_ = tick;
  if (ticks_entry_ != nullptr) {
    ++ticks_entry_->value;
  } else {
    put({.value = 1});
  }
  if (!is_recording_) return;
  Segment& segment = current();
  ++segment.ticks;
  if (open_.number != 0) {
    if (tick_ >= open_until_) return end_window(bank);
    if (hands_over_ && !std::exchange(is_open_handed_over_, true)) return hand_over_open(bank);
  }
  if (is_complete(segment)) begin_segment(bank, tick, Segment::Cause::continued);
}

/// Ends a segment early once its entries take a quarter of the blocks: segments are dropped whole,
/// and dropping a larger one would lose too much of the record.
bool BlackBox::is_complete(const Segment& segment) const noexcept {
  return segment.ticks >= segment_ticks_ ||
         segment.entries > blocks_.capacity() / 4 * kEntriesOfBlock;
}

void BlackBox::record_event(const EventRecord& event) noexcept {
  if (!is_recording_) return;
  put({.value = static_cast<std::int64_t>(event.session),
       .code = event.code,
       .axis = event.axis,
       .address = {static_cast<std::uint16_t>(event.kind), 0},
       .kind = BoxEntry::Kind::event});
  if (const auto kind = cause_kind(event.kind)) {
    const std::uint32_t code = *kind == WindowCause::Kind::fault ? event.code : 0;
    static_cast<void>(
        freeze({.kind = *kind, .axis = event.axis, .code = code, .session = event.session}));
  }
}

// NOLINTEND(bugprone-exception-escape)

std::uint64_t BlackBox::freeze(const WindowCause& cause) {
  if (!is_recording_) return 0;
  if (open_.number == 0) {
    open_ = {.number = ++last_number_,
             .first_tick = std::max(tick_, ticks_before_) - ticks_before_};
  }
  open_.last_tick = tick_;
  const std::uint64_t begin = open_.cause_count == 0 ? tick_ : open_.causes[0].tick;
  open_until_ =
      std::min(tick_ + ticks_after_, begin + ticks_after_ * (kLongestAfter / kAfterCause));
  if (open_.cause_count == Window::kMostCauses) {
    ++open_.more_causes;
  } else {
    open_.causes[open_.cause_count] = cause;
    open_.causes[open_.cause_count].tick = tick_;
    ++open_.cause_count;
  }
  return open_.number;
}

void BlackBox::end_window(const AxisBank& bank) {
  if (open_.number == 0) return;
  Window window = std::exchange(open_, {});
  is_open_handed_over_ = false;
  window.last_tick = tick_;
  collect_segments(window);
  if (windows_.size() == kMostWindows) static_cast<void>(drop_window());
  hold(window);
  windows_.push_back(window);
  if (hands_over_) hand_over(window);
  begin_segment(bank, tick_, Segment::Cause::continued);
}

/// Collects the segments that the window spans, as far as they still exist.
void BlackBox::collect_segments(Window& window) const {
  for (auto slot = recent_.rbegin();
       slot != recent_.rend() && window.segment_count < Window::kMostSegments; ++slot) {
    window.segments[window.segment_count] = *slot;
    ++window.segment_count;
    if (segments_[*slot].tick < window.first_tick) break;
  }
  std::reverse(window.segments.begin(), window.segments.begin() + window.segment_count);
  window.first_tick = std::max(window.first_tick, segments_[window.segments[0]].tick);
}

/// Hands over the part of the open window that has been recorded so far.
void BlackBox::hand_over_open(const AxisBank& bank) {
  Window so_far = open_;
  so_far.last_tick = tick_;
  collect_segments(so_far);
  hand_over(so_far);
  begin_segment(bank, tick_, Segment::Cause::continued);
}

/// If the queue is full, the window stays in memory only.
void BlackBox::hand_over(const Window& window) noexcept {
  Window* const slot = handed_over_.free_slot();
  if (slot == nullptr) return;
  *slot = window;
  hold(*slot);
  handed_over_.push();
}

void BlackBox::pop_handed_over() noexcept {
  let_go(*handed_over_.front());
  handed_over_.pop();
}

bool BlackBox::adopt(const Window& window, std::span<const KeptSegment> segments) {
  if (windows_.size() == kMostWindows || !has_room_for(segments)) return false;
  Window kept = window;
  kept.segment_count = 0;
  for (const KeptSegment& segment : segments) {
    const auto slot = take_slot();
    if (!slot || !open(*slot, segment.tick, segment.cause)) break;
    Segment& mine = segments_[*slot];
    kept.segments[kept.segment_count] = *slot;
    ++kept.segment_count;
    std::ranges::copy(segment.state, mine.state.begin());
    mine.ticks = segment.ticks;
    for (const BoxEntry& entry : segment.entries) static_cast<void>(append(mine, entry));
  }
  windows_.insert(windows_.begin(), kept);
  last_number_ = std::max(last_number_, kept.number);
  return true;
}

/// Adopted windows may take half of the memory: the new run needs the rest.
bool BlackBox::has_room_for(std::span<const KeptSegment> segments) const noexcept {
  std::size_t blocks = blocks_made_;
  for (const KeptSegment& segment : segments) {
    blocks += segment.entries.size() / kEntriesOfBlock + 1;
  }
  std::size_t slots = segments.size();
  for (std::size_t slot = 0; slot < slots_; ++slot) {
    slots += segments_[slot].holders.load(std::memory_order_relaxed) > 0 ? 1 : 0;
  }
  return slots <= slots_ / 2 && blocks <= blocks_.capacity() / 2;
}

const Window* BlackBox::next_window(std::uint64_t number) const noexcept {
  const auto next = std::ranges::upper_bound(windows_, number, {}, &Window::number);
  if (next != windows_.end()) return &*next;
  return open_.number > number ? &open_ : nullptr;
}

void BlackBox::hold(const Window& window) noexcept {
  for (std::size_t place = 0; place < window.segment_count; ++place) {
    segments_[window.segments[place]].holders.fetch_add(1, std::memory_order_relaxed);
  }
}

void BlackBox::let_go(const Window& window) noexcept {
  for (std::size_t place = 0; place < window.segment_count; ++place) {
    segments_[window.segments[place]].holders.fetch_sub(1, std::memory_order_release);
  }
}

/// If all memory is held, recording stops; record_tick() tries again later.
void BlackBox::begin_segment(const AxisBank& bank, std::uint64_t tick, Segment::Cause cause) {
  ticks_entry_ = nullptr;
  author_.reset();
  const auto slot = take_slot();
  is_recording_ = slot && open(*slot, tick, cause);
  if (!is_recording_) return;
  bank.save(segments_[*slot].state);
  recent_.push_back(*slot);
  tick_ = tick;
}

/// Makes the slot an empty segment. @return false if there is no block for it.
bool BlackBox::open(std::uint32_t slot, std::uint64_t tick, Segment::Cause cause) {
  const auto block = take_block();
  if (!block) return false;
  Segment& segment = segments_[slot];
  segment.cause = cause;
  segment.tick = tick;
  segment.ticks = 0;
  segment.first_block = segment.last_block = *block;
  segment.has_blocks = true;
  segment.entries = 0;
  segment.holders.store(1, std::memory_order_relaxed);
  return true;
}

void BlackBox::put(const BoxEntry& entry) {
  ticks_entry_ = nullptr;
  if (!is_recording_) return;
  BoxEntry* const kept = append(current(), entry);
  is_recording_ = kept != nullptr;
  if (entry.kind == BoxEntry::Kind::ticks) ticks_entry_ = kept;
}

/// @return the entry, or nullptr if there is no room.
BoxEntry* BlackBox::append(Segment& segment, const BoxEntry& entry) {
  const std::size_t place = segment.entries % kEntriesOfBlock;
  if (place == 0 && segment.entries > 0) {
    const auto block = take_block();
    if (!block) return nullptr;
    blocks_[segment.last_block].next = *block;
    segment.last_block = *block;
  }
  BoxEntry& kept = blocks_[segment.last_block].entries[place];
  kept = entry;
  ++segment.entries;
  return &kept;
}

std::optional<std::uint32_t> BlackBox::take_slot() {
  do {
    for (std::uint32_t slot = 0; slot < slots_; ++slot) {
      if (segments_[slot].holders.load(std::memory_order_acquire) == 0) {
        recycle_blocks();
        return slot;
      }
    }
  } while (free_oldest());
  return std::nullopt;
}

std::optional<std::uint32_t> BlackBox::take_block() {
  do {
    if (free_block_ == kNone) recycle_blocks();
    if (free_block_ != kNone) {
      const std::uint32_t block = free_block_;
      free_block_ = std::exchange(blocks_[block].next, kNone);
      return block;
    }
    if (blocks_made_ < blocks_.capacity()) {
      static_cast<void>(blocks_.reach(blocks_made_));
      return static_cast<std::uint32_t>(blocks_made_++);
    }
  } while (free_oldest());
  return std::nullopt;
}

/// Frees the blocks of segments that nobody holds.
void BlackBox::recycle_blocks() noexcept {
  for (std::size_t slot = 0; slot < slots_; ++slot) {
    Segment& segment = segments_[slot];
    if (!segment.has_blocks || segment.holders.load(std::memory_order_acquire) != 0) continue;
    blocks_[segment.last_block].next = free_block_;
    free_block_ = segment.first_block;
    segment.has_blocks = false;
  }
}

/// Drops the oldest segment, or a window if only kLeastRecent segments are left.
/// @return whether there was one
bool BlackBox::free_oldest() noexcept {
  if (recent_.size() <= kLeastRecent) return drop_window();
  segments_[recent_.front()].holders.fetch_sub(1, std::memory_order_release);
  recent_.erase(recent_.begin());
  return true;
}

/// @return whether there was one.
bool BlackBox::drop_window() noexcept {
  if (windows_.empty()) return false;
  const auto dropped = windows_.begin() + static_cast<std::ptrdiff_t>(place_to_drop(windows_));
  let_go(*dropped);
  windows_.erase(dropped);
  return true;
}

}  // namespace vdrive::service

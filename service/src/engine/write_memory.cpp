// SPDX-License-Identifier: Apache-2.0
#include "engine/write_memory.hpp"

#include "engine/history_marks.hpp"

#include <algorithm>
#include <optional>
#include <variant>

namespace vdrive::service {
namespace {

using wire::WrittenMark;

constexpr ObjectAddress mark_address(WrittenMark mark) {
  return {0, static_cast<std::uint8_t>(mark)};
}

}  // namespace

WriteMemory::WriteMemory(const std::vector<std::uint16_t>& numbers) : numbers_(numbers) {}

void WriteMemory::put(const JournalEntry& entry, const JournalAuthor& author) {
  if (!is_asked_) return;
  Entry kept{.tick = tick_, .session = author.session, .means = author.means};
  if (const auto* const change = std::get_if<JournalChange>(&entry)) {
    kept.axis = numbers_[change->axis];
    kept.address = change->address;
    kept.value = change->value;
    if (change->kind == JournalChange::Kind::power_cycle) {
      kept.address = mark_address(WrittenMark::power_cycle);
    } else if (change->kind != JournalChange::Kind::write) {
      return;  // not recorded: visible in the status
    }
  } else if (const auto* const refusal = std::get_if<JournalRefusal>(&entry)) {
    kept.axis = numbers_[refusal->axis];
    kept.address = refusal->address;
    kept.value = refusal->value;
    kept.reason = refusal->reason;
  }
  put(kept);
}

void WriteMemory::put_restore() {
  if (!is_asked_) return;
  put({.tick = tick_, .address = mark_address(WrittenMark::restored)});
}

void WriteMemory::put(Entry entry) {
  entries_.reach(count_ % kMost) = entry;
  ++count_;
}

Reason WriteMemory::read(const msg::Request& request, msg::Reply& reply) {
  is_asked_ = true;
  constexpr std::size_t kRoom = msg::MAX_OBJECTS_PER_REQUEST;
  constexpr std::size_t kEntryWithMarks = 3;
  const std::uint64_t oldest = count_ - std::min<std::uint64_t>(count_, kMost);
  std::uint64_t place = std::min(request.snapshot, count_);
  if (place < oldest) {
    add_mark(WrittenMark::tick, entries_[oldest % kMost].tick, reply);
    add_mark(WrittenMark::lost, oldest - place, reply);
    place = oldest;
  }
  std::optional<std::uint64_t> tick;
  std::optional<JournalAuthor> author;
  for (; place < count_ && reply.objects.size() + kEntryWithMarks <= kRoom; ++place) {
    const Entry& entry = entries_[place % kMost];
    if (tick != entry.tick) add_mark(WrittenMark::tick, entry.tick, reply);
    tick = entry.tick;
    const JournalAuthor of_entry{.means = entry.means, .session = entry.session};
    if (author != of_entry) add_mark(mark_of(entry.means), entry.session, reply);
    author = of_entry;
    auto& written = reply.objects.emplace_back();
    written.axis = entry.axis;
    written.index = entry.address.index;
    written.subindex = entry.address.subindex;
    written.abort_code = static_cast<msg::Reason>(entry.reason);
    written.value = entry.value;
  }
  reply.snapshot = place;
  reply.tick = tick_;
  return msg::Reason::none;
}

}  // namespace vdrive::service

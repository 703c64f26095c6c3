// SPDX-License-Identifier: Apache-2.0
#include "engine/window_pages.hpp"

#include "base/log.hpp"
#include "engine/history_marks.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <utility>

namespace vdrive::service {
namespace {

using wire::WrittenMark;
using Item = WindowReplay::Item;

constexpr std::size_t kMostObjects = msg::MAX_OBJECTS_PER_REQUEST;
/// An entry, preceded by up to three marks: its tick, its author and its session.
constexpr std::size_t kItemWithMarks = 4;

/// @return whether Item::state shows the value of this object. It shows every writable object, as
///         any may have been written before, except those that store or restore parameters.
constexpr bool is_shown(const ObjectDescription& row) noexcept {
  return row.access == Access::read_write && row.change != Change::memory;
}

constexpr std::size_t kShownCount = std::ranges::count_if(kObjectRows, is_shown);

constexpr auto kShownRows = [] {
  std::array<ObjectRow, kShownCount> rows{};
  std::size_t count = 0;
  for (std::size_t row = 0; row < kObjectCount; ++row) {
    if (is_shown(kObjectRows[row])) rows[count++] = static_cast<ObjectRow>(row);
  }
  return rows;
}();

constexpr WrittenMark state_mark(BlackBox::Segment::Cause cause) noexcept {
  switch (cause) {
    case BlackBox::Segment::Cause::restored:
      return WrittenMark::restored;
    case BlackBox::Segment::Cause::jumped:
      return WrittenMark::jumped;
    case BlackBox::Segment::Cause::started:
      return WrittenMark::resumed;
    case BlackBox::Segment::Cause::continued:
      break;
  }
  return WrittenMark::began;
}

}  // namespace

WindowPages::WindowPages(const Configuration& configuration, BlackBox& box)
    : configuration_(configuration), box_(box) {}

/// Catches exceptions, because a window from a file of an earlier run may have an invalid state.
void WindowPages::complete(OutgoingReply& outgoing) {
  const auto page = std::move(outgoing.page);
  try {
    if (!continues(*page)) go_to(*page);
    page_ = *page;
    has_context_ = false;
    while (item_ != Item::end && add_item(outgoing)) {
    }
    outgoing.reply.snapshot = item_ == Item::end ? 0 : place_;
  } catch (const std::exception& error) {
    log_warning("window {} of the black box cannot be read: {}", page->window.number, error.what());
    replay_.reset();
    outgoing.reply.objects.clear();
    outgoing.axes.clear();
    outgoing.reply.reason = msg::Reason::unknown_window;
  }
  box_.let_go(page->window);
  box_.pages_waiting.fetch_sub(1, std::memory_order_relaxed);
}

bool WindowPages::continues(const WindowPage& page) const {
  return replay_ && page.window.number == page_.window.number && page.axes == page_.axes &&
         page.place == place_;
}

void WindowPages::go_to(const WindowPage& page) {
  if (!replay_) replay_.emplace(configuration_);
  replay_->start(box_, page.window, page.axes);
  page_ = page;
  place_ = 0;
  value_ = 0;
  item_ = replay_->next();
  while (item_ != Item::end && place_ < page.place) advance();
}

/// Goes to the next item. Of an Item::state each value counts as one item, and all statuses
/// together as one more.
void WindowPages::advance() {
  ++place_;
  if (item_ == Item::state && value_ < kShownRows.size() * page_.axes.size()) {
    ++value_;
    return;
  }
  value_ = 0;
  item_ = replay_->next();
}

/// @return false if the page has no room for the item.
bool WindowPages::add_item(OutgoingReply& outgoing) {
  bool has_room = false;
  switch (item_) {
    case Item::state:
      has_room = value_ < kShownRows.size() * page_.axes.size() ? add_value(outgoing.reply)
                                                                : add_statuses(outgoing);
      break;
    case Item::tick:
      has_room = add_statuses(outgoing);
      break;
    case Item::entry:
      has_room = add_entry(outgoing.reply);
      break;
    case Item::end:
      break;
  }
  if (has_room) advance();
  return has_room;
}

bool WindowPages::add_value(msg::Reply& reply) {
  if (reply.objects.size() + kItemWithMarks > kMostObjects) return false;
  if (!has_context_ || value_ == 0) {
    add_mark(WrittenMark::tick, replay_->tick(), reply);
    add_mark(value_ == 0 ? state_mark(replay_->cause()) : WrittenMark::began, 0, reply);
    has_context_ = true;
    shown_author_.reset();
  }
  const std::size_t axis = page_.axes[value_ / kShownRows.size()];
  const ObjectRow row = kShownRows[value_ % kShownRows.size()];
  const ObjectAddress address = kObjectRows[static_cast<std::size_t>(row)].address;
  auto& value = reply.objects.emplace_back();
  value.axis = configuration_.axes[axis].number;
  value.index = address.index;
  value.subindex = address.subindex;
  value.value = replay_->bank().read(axis, row).value;
  return true;
}

bool WindowPages::add_entry(msg::Reply& reply) {
  const BoxEntry& entry = replay_->entry();
  if (reply.objects.size() + kItemWithMarks > kMostObjects) return false;
  add_context(reply);
  if (entry.kind == BoxEntry::Kind::event) {
    if (entry.value != 0) {
      add_mark(WrittenMark::of_session, static_cast<std::uint64_t>(entry.value), reply);
    }
    auto& event = add_mark(WrittenMark::event, entry.address.index, reply);
    event.axis = entry.axis;
    event.abort_code = static_cast<msg::Reason>(entry.code);
    return true;
  }
  auto& written = reply.objects.emplace_back();
  written.axis = configuration_.axes[entry.axis].number;
  written.abort_code = static_cast<msg::Reason>(entry.code);
  written.value = entry.value;
  written.index = entry.address.index;
  written.subindex = entry.address.subindex;
  if (entry.kind == BoxEntry::Kind::refusal) return true;
  if (entry.change == JournalChange::Kind::power_cycle) {
    written.subindex = static_cast<std::uint8_t>(WrittenMark::power_cycle);
  } else if (entry.change == JournalChange::Kind::connection_loss) {
    written.subindex = static_cast<std::uint8_t>(WrittenMark::connection_loss);
  } else if (entry.change != JournalChange::Kind::write) {
    reply.objects.pop_back();  // not shown: they only take effect after a power cycle
  }
  return true;
}

/// Adds marks of the tick and the author, unless the page has marks that still apply.
void WindowPages::add_context(msg::Reply& reply) {
  const JournalAuthor& author = replay_->author();
  if (has_context_ && shown_tick_ == replay_->tick() && shown_author_ == author) return;
  shown_tick_ = replay_->tick();
  shown_author_ = author;
  has_context_ = true;
  add_mark(WrittenMark::tick, shown_tick_, reply);
  add_mark(mark_of(author.means), author.session, reply);
}

bool WindowPages::add_statuses(OutgoingReply& outgoing) const {
  auto& shown = outgoing.axes;
  if (shown.size() + page_.axes.size() > msg::MAX_AXES_PER_FRAME) return false;
  for (const std::size_t axis : page_.axes) {
    shown.push_back({.number = configuration_.axes[axis].number,
                     .tick = replay_->tick(),
                     .owner = {},
                     .status = replay_->bank().status(axis)});
  }
  return true;
}

}  // namespace vdrive::service

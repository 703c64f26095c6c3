// SPDX-License-Identifier: Apache-2.0
#include "journal/window_replay.hpp"

#include <algorithm>

namespace vdrive::service {

const BoxEntry* BlackBox::Entries::next() noexcept {
  if (left_ == 0) return nullptr;
  if (place_ == kEntriesOfBlock) {
    block_ = box_->blocks_[block_].next;
    place_ = 0;
  }
  --left_;
  return &box_->blocks_[block_].entries[place_++];
}

WindowReplay::WindowReplay(const Configuration& configuration)
    : bank_(bank_axes(configuration), configuration.period) {
  numbers_.reserve(configuration.axes.size());
  for (const NamedAxis& axis : configuration.axes) numbers_.push_back(axis.number);
}

void WindowReplay::start(const BlackBox& box, const Window& window,
                         std::span<const std::size_t> axes) {
  box_ = &box;
  window_ = window;
  is_wanted_.assign(bank_.size(), false);
  groups_.clear();
  for (const std::size_t axis : axes) {
    is_wanted_[axis] = true;
    groups_.push_back(bank_.group_of(axis));
  }
  std::ranges::sort(groups_);
  groups_.erase(std::unique(groups_.begin(), groups_.end()), groups_.end());
  next_segment_ = 0;
  entries_.reset();
  ticks_left_ = 0;
  is_shown_ = false;
}

WindowReplay::Item WindowReplay::next() {
  while (true) {
    if (ticks_left_ > 0) {
      if (tick_ == window_.last_tick) return Item::end;
      if (const auto item = complete_tick()) return *item;
    } else if (const BoxEntry* const entry = entries_ ? entries_->next() : nullptr) {
      if (take(*entry)) return Item::entry;
    } else if (next_segment_ == window_.segment_count) {
      return Item::end;
    } else if (open_segment()) {
      return Item::state;
    }
  }
}

/// @return the item to show; nullopt before the window begins.
std::optional<WindowReplay::Item> WindowReplay::complete_tick() {
  --ticks_left_;
  step();
  if (is_shown_) return Item::tick;
  if (tick_ < window_.first_tick) return std::nullopt;
  is_shown_ = true;
  return Item::state;
}

/// @return whether the entry is shown.
bool WindowReplay::take(const BoxEntry& entry) {
  if (entry.kind == BoxEntry::Kind::ticks) {
    ticks_left_ = static_cast<std::uint64_t>(entry.value);
    return false;
  }
  if (entry.kind == BoxEntry::Kind::author) {
    author_ = {.means = entry.means, .session = static_cast<std::uint64_t>(entry.value)};
    return false;
  }
  if (!is_of_interest(entry)) return false;
  apply(entry);
  entry_ = entry;
  return is_shown_;
}

/// @return whether the state is shown, because it differs from the one after the last tick.
bool WindowReplay::open_segment() {
  using Cause = BlackBox::Segment::Cause;
  const BlackBox::Segment& segment = box_->segment(window_.segments[next_segment_]);
  const bool is_first = next_segment_ == 0;
  ++next_segment_;
  entries_.emplace(*box_, segment);
  cause_ = segment.cause;
  if (!is_first && cause_ == Cause::continued) return false;
  bank_.restore(bank_.snapshot_from(segment.state));
  tick_ = segment.tick;
  if (is_first && tick_ >= window_.first_tick) cause_ = Cause::started;
  is_shown_ = is_shown_ || tick_ >= window_.first_tick;
  return is_shown_;
}

void WindowReplay::step() {
  for (const std::size_t group : groups_) bank_.step_groups(group, group + 1);
  ++tick_;
}

/// Events of the bench itself are of interest, too.
bool WindowReplay::is_of_interest(const BoxEntry& entry) const {
  if (entry.kind != BoxEntry::Kind::event) return is_wanted_[entry.axis];
  if (entry.axis == 0) return true;
  const auto number = std::ranges::lower_bound(numbers_, entry.axis);
  return number != numbers_.end() && *number == entry.axis &&
         is_wanted_[static_cast<std::size_t>(number - numbers_.begin())];
}

void WindowReplay::apply(const BoxEntry& entry) {
  if (entry.kind != BoxEntry::Kind::change) return;
  // Each recorded change was accepted, and is accepted again: the state is bit-identical.
  switch (entry.change) {
    case JournalChange::Kind::write:
      static_cast<void>(bank_.write(entry.axis, entry.address, entry.value));
      break;
    case JournalChange::Kind::power_cycle:
      bank_.power_cycle(entry.axis);
      break;
    case JournalChange::Kind::connection_loss:
      bank_.report_connection_loss(entry.axis);
      break;
    case JournalChange::Kind::stored:
      static_cast<void>(bank_.set_stored(entry.axis, entry.address, entry.value));
      break;
    case JournalChange::Kind::forgot:
      bank_.forget_stored(entry.axis);
      break;
  }
}

}  // namespace vdrive::service

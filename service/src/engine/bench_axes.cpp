// SPDX-License-Identifier: Apache-2.0
#include "engine/bench_axes.hpp"

#include "vdrive/dictionary/dictionary.hpp"

#include <variant>

namespace vdrive::service {

BenchAxes::BenchAxes(const Configuration& configuration)
    : bank_(bank_axes(configuration), configuration.period),
      pool_(bank_, configuration.threads),
      indices_(end_of_numbers(configuration), static_cast<std::uint16_t>(kMaxAxes)),
      changed_(configuration.axes.size()),
      writes_(numbers_),
      black_box_(configuration, bank_) {
  for (const auto& axis : configuration.axes) {
    indices_[axis.number] = static_cast<std::uint16_t>(numbers_.size());
    numbers_.push_back(axis.number);
  }
  black_box_.begin(bank_, 0);
}

void BenchAxes::start_at(std::uint64_t last_tick) {
  writes_.set_tick(last_tick);
  black_box_.begin(bank_, last_tick);
}

void BenchAxes::record_to(Journal& journal, std::uint64_t tick) {
  journal.begin(bank_, tick);
  journal_ = &journal;
}

AbortCode BenchAxes::write(std::size_t axis, ObjectRow row, std::int64_t value) {
  const AbortCode code = bank_.write(axis, row, value);
  if (code == AbortCode::none) {
    record(JournalChange{.axis = static_cast<std::uint16_t>(axis),
                         .address = describe(row).address,
                         .value = value});
    changed_.mark(axis);
  }
  return code;
}

void BenchAxes::record_refusal(std::size_t axis, ObjectAddress address, std::int64_t value,
                               Reason reason) {
  record(JournalRefusal{.axis = static_cast<std::uint16_t>(axis),
                        .address = address,
                        .value = value,
                        .reason = reason.code()});
}

AbortCode BenchAxes::write_signature(std::size_t axis, ObjectRow row, std::int64_t value) {
  return bank_.write(axis, row, value);
}

void BenchAxes::power_cycle(std::size_t axis) {
  bank_.power_cycle(axis);
  record(JournalChange{.kind = JournalChange::Kind::power_cycle,
                       .axis = static_cast<std::uint16_t>(axis)});
  changed_.mark(axis);
}

void BenchAxes::lose_connection(std::size_t axis) {
  bank_.report_connection_loss(axis);
  record(JournalChange{.kind = JournalChange::Kind::connection_loss,
                       .axis = static_cast<std::uint16_t>(axis)});
}

void BenchAxes::forget_stored(std::size_t axis) {
  bank_.forget_stored(axis);
  record(
      JournalChange{.kind = JournalChange::Kind::forgot, .axis = static_cast<std::uint16_t>(axis)});
}

void BenchAxes::set_stored(std::size_t axis, std::span<const std::int64_t> values) {
  ensure(values.size() == kStoredRows.size(), "each stored object has its value");
  for (std::size_t position = 0; position < values.size(); ++position) {
    const ObjectAddress address = describe(kStoredRows[position]).address;
    bank_.set_stored(axis, address, values[position]);
    record(JournalChange{.kind = JournalChange::Kind::stored,
                         .axis = static_cast<std::uint16_t>(axis),
                         .address = address,
                         .value = values[position]});
  }
}

void BenchAxes::restore(const std::shared_ptr<const AxisBank::Snapshot>& snapshot,
                        std::uint64_t tick) {
  bank_.restore(*snapshot, AxisBank::Memory::kept);
  if (journal_ != nullptr) journal_->record_restore(snapshot, tick);
  writes_.put_restore();
  black_box_.record_restore(bank_, tick);
  for (std::size_t axis = 0; axis < size(); ++axis) changed_.mark(axis);
}

void BenchAxes::record_tick(std::uint64_t tick) {
  if (journal_ != nullptr) journal_->record_tick(bank_, tick);
  writes_.set_tick(tick);
  black_box_.record_tick(bank_, tick);
}

std::optional<JournalNews> BenchAxes::next_journal_news() {
  return journal_ == nullptr ? std::nullopt : journal_->news();
}

void BenchAxes::record(const JournalEntry& entry) {
  if (journal_ != nullptr) journal_->record(entry, author_);
  const auto* const refusal = std::get_if<JournalRefusal>(&entry);
  // In replies, index 0 identifies a mark (wire::WrittenMark) and not a write.
  if (refusal != nullptr && refusal->address.index == 0) return;
  writes_.put(entry, author_);
  black_box_.record(entry, author_);
}

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/reason.hpp"
#include "base/step_pool.hpp"
#include "configuration/configuration.hpp"
#include "engine/changed_axes.hpp"
#include "engine/write_memory.hpp"
#include "journal/black_box.hpp"
#include "journal/journal.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/axis_bank.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::service {

/// The axes of a bench, by number and by index. Every change of an axis goes through this class, so
/// the journal records it and the parameters of the axis are sent again.
class BenchAxes {
 public:
  /// While it exists, what is done to the axes is done for this author. Without one the bench
  /// itself does it.
  class Authorship {
   public:
    Authorship(BenchAxes& axes, const JournalAuthor& author) : axes_(axes) {
      axes_.author_ = author;
    }

    ~Authorship() { axes_.author_ = {}; }

    Authorship(const Authorship&) = delete;
    Authorship& operator=(const Authorship&) = delete;

   private:
    BenchAxes& axes_;
  };

  /// @throws std::invalid_argument when the bank refuses the axes
  explicit BenchAxes(const Configuration& configuration);

  /// Before the first step: the first tick is the one after `last_tick`.
  void start_at(std::uint64_t last_tick);

  /// Before the first change: records into `journal`, which outlives this object.
  /// @throws std::system_error when the journal cannot be begun
  void record_to(Journal& journal, std::uint64_t tick);

  [[nodiscard]] std::size_t size() const noexcept { return numbers_.size(); }

  [[nodiscard]] const AxisBank& bank() const noexcept { return bank_; }

  [[nodiscard]] std::uint16_t number_of(std::size_t axis) const noexcept {
    ensure(axis < size(), "the axis is one of the bench's");
    return numbers_[axis];
  }

  /// @return the index of the axis with this number, if there is one.
  [[nodiscard]] std::optional<std::size_t> index_of(std::uint16_t number) const noexcept {
    if (number >= indices_.size() || indices_[number] == kMaxAxes) return std::nullopt;
    return indices_[number];
  }

  /// @return the index of an axis that the bench has: the message that names it was checked.
  [[nodiscard]] std::size_t index_of_checked(std::uint16_t number) const noexcept {
    const auto index = index_of(number);
    ensure(index.has_value(), "a checked message names axes of this bench");
    return *index;
  }

  /// @return the abort code of the refusal, or AbortCode::none
  AbortCode write(std::size_t axis, ObjectRow row, std::int64_t value);

  /// A write that was refused without or after a question to the bank: nothing changes.
  void record_refusal(std::size_t axis, ObjectAddress address, std::int64_t value, Reason reason);

  /// 1010h and 1011h: the bank judges the signature, and nothing changes.
  AbortCode write_signature(std::size_t axis, ObjectRow row, std::int64_t value);

  void power_cycle(std::size_t axis);

  /// The master of the axis fell silent.
  void lose_connection(std::size_t axis);

  /// Nothing is stored for the axis from the next power cycle on.
  void forget_stored(std::size_t axis);

  /// From the next power cycle on the axis has these values of kStoredRows.
  void set_stored(std::size_t axis, std::span<const std::int64_t> values);

  /// Gives all axes the state of the snapshot, but for what is stored: that is on a disk.
  void restore(const std::shared_ptr<const AxisBank::Snapshot>& snapshot, std::uint64_t tick);

  /// One tick of all axes.
  void step() { pool_.step(); }

  /// Calls `work(first, last)` for parts that together are 0 to `count`, which stand for the axes
  /// in their order: in the threads that step these axes, where there are enough to be worth it.
  /// @param work throws nothing
  template <typename Work>
  void share(std::size_t count, const Work& work) noexcept {
    // Fewer axes are copied in less time than the threads need to meet.
    constexpr std::size_t kWorthSharing = 1'024;
    if (size() < kWorthSharing) {
      work(0, count);
    } else {
      pool_.share(count, work);
    }
  }

  /// The calling thread will step: the threads that help get its schedule.
  void schedule_as_caller() noexcept { pool_.schedule_as_caller(); }

  /// The tick is complete.
  void record_tick(std::uint64_t tick);

  /// @return what the journal has not reported yet.
  [[nodiscard]] std::optional<JournalNews> next_journal_news();

  /// What was written last.
  [[nodiscard]] WriteMemory& writes() noexcept { return writes_; }

  /// What happened in the last minutes.
  [[nodiscard]] BlackBox& black_box() noexcept { return black_box_; }

  /// The axes whose parameters have to be sent.
  [[nodiscard]] ChangedAxes& changed() noexcept { return changed_; }

 private:
  void record(const JournalEntry& entry);

  AxisBank bank_;
  StepPool pool_;
  std::vector<std::uint16_t> numbers_;  ///< by index
  std::vector<std::uint16_t> indices_;  ///< by number, as far as there are axes; kMaxAxes = none
  ChangedAxes changed_;
  WriteMemory writes_;
  BlackBox black_box_;
  Journal* journal_ = nullptr;
  JournalAuthor author_;
};

}  // namespace vdrive::service

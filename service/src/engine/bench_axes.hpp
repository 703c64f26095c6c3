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

/// The axes of a bench, by number and by index. Every change to an axis goes through this class, so
/// that the journal records it and the parameters of the axis are sent again.
class BenchAxes {
 public:
  /// While this object exists, changes to the axes are attributed to `author`; otherwise to the
  /// bench itself.
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

  /// @throws std::invalid_argument if the bank refuses the axes
  explicit BenchAxes(const Configuration& configuration);

  /// Sets the last completed tick. Only before the first step.
  void start_at(std::uint64_t last_tick);

  /// Records all changes to `journal`, which outlives this object. Only before the first change.
  /// @throws std::system_error if the journal cannot be written
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

  /// @return the index of an axis that is known to exist, because the message that names it was
  ///         checked.
  [[nodiscard]] std::size_t index_of_checked(std::uint16_t number) const noexcept {
    const auto index = index_of(number);
    ensure(index.has_value(), "a checked message names axes of this bench");
    return *index;
  }

  /// @return the abort code of the refusal, or AbortCode::none
  AbortCode write(std::size_t axis, ObjectRow row, std::int64_t value);

  /// Records a refused write, whether or not the bank was asked. Nothing changes.
  void record_refusal(std::size_t axis, ObjectAddress address, std::int64_t value, Reason reason);

  /// Has the bank check the signature written to 1010h or 1011h. Nothing changes.
  AbortCode write_signature(std::size_t axis, ObjectRow row, std::int64_t value);

  void power_cycle(std::size_t axis);

  /// Reports to the axis that its master has fallen silent.
  void lose_connection(std::size_t axis);

  /// Clears the stored values of the axis, effective from its next power cycle on.
  void forget_stored(std::size_t axis);

  /// Sets the stored values of the axis (of kStoredRows), effective from its next power cycle on.
  void set_stored(std::size_t axis, std::span<const std::int64_t> values);

  /// Sets all axes to the state of the snapshot, except for their stored values: those are on disk.
  void restore(const std::shared_ptr<const AxisBank::Snapshot>& snapshot, std::uint64_t tick);

  void step() { pool_.step(); }

  /// Calls `work(first, last)` for parts of [0, count), a range that stands for the axes in order.
  /// If there are enough axes, the parts run in the threads that step these axes.
  /// @param work must not throw
  template <typename Work>
  void share(std::size_t count, const Work& work) noexcept {
    // Fewer axes are processed in less time than the threads take to synchronise.
    constexpr std::size_t kWorthSharing = 1'024;
    if (size() < kWorthSharing) {
      work(0, count);
    } else {
      pool_.share(count, work);
    }
  }

  /// Called by the thread that will step: gives its scheduling policy and priority to its helpers.
  void schedule_as_caller() noexcept { pool_.schedule_as_caller(); }

  void record_tick(std::uint64_t tick);

  /// @return the next unreported news of the journal.
  [[nodiscard]] std::optional<JournalNews> next_journal_news();

  [[nodiscard]] WriteMemory& writes() noexcept { return writes_; }

  [[nodiscard]] BlackBox& black_box() noexcept { return black_box_; }

  /// @return the axes whose parameters have to be sent.
  [[nodiscard]] ChangedAxes& changed() noexcept { return changed_; }

 private:
  void record(const JournalEntry& entry);

  AxisBank bank_;
  StepPool pool_;
  std::vector<std::uint16_t> numbers_;  ///< by index
  std::vector<std::uint16_t> indices_;  ///< by number, up to the highest one; kMaxAxes = no axis
  ChangedAxes changed_;
  WriteMemory writes_;
  BlackBox black_box_;
  Journal* journal_ = nullptr;
  JournalAuthor author_;
};

}  // namespace vdrive::service

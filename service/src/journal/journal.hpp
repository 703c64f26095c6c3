// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "base/event_record.hpp"
#include "base/ring.hpp"
#include "configuration/configuration.hpp"
#include "journal/journal_file.hpp"
#include "vdrive/axis_bank.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

namespace vdrive::service {

/// Opens the file of a journal, which must be new or empty.
/// @throws ConfigurationError when it is not empty, is locked by another bench or cannot be opened
[[nodiscard]] JournalSink open_journal(const std::filesystem::path& file);

/// A change in the state of the journal that has to be reported.
struct JournalNews {
  std::uint32_t code = 0;  ///< JournalCode
  EventDetail detail{};
};

/// Records the inputs of a bench and a check of every tick. The thread that steps the bank fills a
/// bounded queue, without lock, allocation or system call; a separate thread writes the file. When
/// the queue is full, lock-step and freerun wait, so nothing is missing. Real time cannot wait:
/// complete ticks are lost and counted, and the journal continues with a new snapshot once the
/// queue is half empty.
class Journal {
 public:
  /// Slots of the queue. A tick takes one slot, or several if it has many entries.
  static constexpr std::size_t kSlots = 4096;
  /// The maximum number of check rows. With up to this many axes each axis has its own row.
  static constexpr std::size_t kMostRows = 256;

  /// Writes nothing before begin().
  Journal(const Configuration& configuration, JournalSink sink, Counters& counters);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Writes the head and the first snapshot, and starts the thread that writes.
  /// @throws std::system_error when they cannot be written
  void begin(const AxisBank& bank, std::uint64_t tick);

  /// Writes what is queued, and the end mark. Nothing is recorded afterwards. Idempotent.
  void close() noexcept;

  // The functions below are for the thread that steps the bank.

  /// Records an accepted change or a refused write, and its author.
  void record(const JournalEntry& entry, const JournalAuthor& author) noexcept;
  /// Records that the state was replaced by the state of a snapshot.
  void record_restore(std::shared_ptr<const AxisBank::Snapshot> snapshot,
                      std::uint64_t tick) noexcept;
  void record_tick(const AxisBank& bank, std::uint64_t tick) noexcept;

  /// @return the next piece of news that has not been reported yet.
  [[nodiscard]] std::optional<JournalNews> news() noexcept;

 private:
  /// Entries, and the record that follows them (`end`).
  struct Slot {
    enum class End : std::uint8_t { none, tick, restored, resumed };

    /// A slot has a fixed size: a tick with more entries takes several slots.
    static constexpr std::size_t kEntries = 64;

    End end = End::none;
    std::uint32_t entry_count = 0;
    std::uint64_t tick = 0;
    std::uint64_t lost = 0;
    StatusDigest digest;
    std::array<JournalEntry, kEntries> entries;
    std::array<std::uint32_t, kMostRows> rows{};
    std::shared_ptr<const AxisBank::Snapshot> snapshot;
  };

  [[nodiscard]] bool is_recording() const noexcept;
  [[nodiscard]] Slot* open_slot() noexcept;
  void put(const JournalEntry& entry) noexcept;
  void push(Slot::End end, std::uint64_t tick) noexcept;
  void start_losing() noexcept;
  void lose_tick(const AxisBank& bank, std::uint64_t tick) noexcept;

  void write() noexcept;
  [[nodiscard]] bool write_waiting();
  void write_slot(Slot& slot);

  JournalStart start_;
  JournalSink sink_;
  Counters& counters_;
  bool may_wait_;
  Ring<Slot> ring_;
  std::optional<JournalWriter> writer_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  std::atomic<int> error_{0};            ///< errno of the write that failed
  std::atomic<bool> spare_used_{false};  ///< the writer still needs `spare_`

  // Only for the thread that steps the bank.
  std::shared_ptr<AxisBank::Snapshot> spare_;  ///< to continue with after a loss
  Slot* slot_ = nullptr;                       ///< being filled
  std::optional<JournalAuthor> author_;        ///< of the last entry; nullopt: record the next one
  std::uint64_t lost_ = 0;                     ///< ticks in the present loss
  bool losing_ = false;
  bool ended_ = true;
  bool reported_loss_ = true;
  bool reported_end_ = false;
  std::uint64_t resumed_after_ = 0;  ///< lost ticks that still have to be reported
};

}  // namespace vdrive::service

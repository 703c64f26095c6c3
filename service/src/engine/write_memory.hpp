// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/lazy_slots.hpp"
#include "base/reason.hpp"
#include "journal/journal_file.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::service {

/// The last writes to the axes of a bench, accepted or refused, and their authors, as returned by
/// REQUEST_READ_WRITES. Recording starts with the first such request, so a bench that never gets
/// one uses no memory for it. Recording needs no lock, allocation or system call.
class WriteMemory {
 public:
  /// Holds half a second of writes if 64 axes each get a target and a controlword every
  /// millisecond.
  static constexpr std::size_t kMost = 65'536;

  /// @param numbers of the axes, by index; outlives this object
  explicit WriteMemory(const std::vector<std::uint16_t>& numbers);

  void put(const JournalEntry& entry, const JournalAuthor& author);

  /// Records that all axes were set to the state of a snapshot.
  void put_restore();

  /// Sets the last completed tick.
  void set_tick(std::uint64_t tick) noexcept { tick_ = tick; }

  /// Answers with the entries after place `request.snapshot`, as many as fit, and with the place of
  /// the last one.
  [[nodiscard]] Reason read(const msg::Request& request, msg::Reply& reply);

 private:
  struct Entry {
    std::uint64_t tick = 0;
    std::uint64_t session = 0;
    std::int64_t value = 0;
    std::uint32_t reason = 0;
    std::uint16_t axis = 0;  ///< number; 0 = all
    ObjectAddress address{};
    JournalAuthor::Means means = JournalAuthor::Means::none;
  };

  void put(Entry entry);

  const std::vector<std::uint16_t>& numbers_;
  LazySlots<Entry> entries_{kMost};
  bool is_asked_ = false;    ///< a client has asked
  std::uint64_t count_ = 0;  ///< of all entries so far: the place of the last one
  std::uint64_t tick_ = 0;
};

}  // namespace vdrive::service

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

/// The last writes to the axes of a bench, accepted or refused, and who made them: what
/// REQUEST_READ_WRITES returns, from the first of these requests on. A bench that nobody asks
/// spends no memory. Recording takes no lock, allocation or system call.
class WriteMemory {
 public:
  /// The writes of half a second, where 64 axes get a target and a controlword each millisecond.
  static constexpr std::size_t kMost = 65'536;

  /// @param numbers of the axes, by index; they outlive this object
  explicit WriteMemory(const std::vector<std::uint16_t>& numbers);

  void put(const JournalEntry& entry, const JournalAuthor& author);

  /// All axes got the state of a snapshot.
  void put_restore();

  /// The tick is complete.
  void set_tick(std::uint64_t tick) noexcept { tick_ = tick; }

  /// Answers with the entries after the place `request.snapshot`, as many as fit, and with the
  /// place of the last of them.
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
  bool is_asked_ = false;    ///< somebody has asked
  std::uint64_t count_ = 0;  ///< of all so far: the place of the last one
  std::uint64_t tick_ = 0;
};

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "journal/journal_file.hpp"
#include "vdrive/axis_bank.hpp"

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>

namespace vdrive::service {

/// What came of a replay.
struct ReplayResult {
  bool agrees = true;       ///< every check that the journal has
  bool is_complete = true;  ///< no tick is missing, and the journal has its end
  std::string text;         ///< one line for people
  std::uint64_t ticks = 0;
  std::uint64_t changes = 0;
};

/// Is told what a replay does, after it has been done.
class ReplayObserver {
 public:
  ReplayObserver() = default;
  virtual ~ReplayObserver() = default;
  ReplayObserver(const ReplayObserver&) = delete;
  ReplayObserver& operator=(const ReplayObserver&) = delete;

  /// @param has_authors the journal is of a version that records authors and refusals
  virtual void begins(const Configuration& configuration, bool has_authors) = 0;
  /// All axes have the state of `snapshot`.
  virtual void restored(const JournalSnapshot& snapshot, const AxisBank& bank) = 0;
  virtual void entered(const JournalChange& change, const AxisBank& bank) = 0;
  virtual void entered(const JournalRefusal& refusal, const AxisBank& bank) = 0;
  virtual void entered(const JournalAuthor& author, const AxisBank& bank) = 0;
  virtual void stepped(std::uint64_t tick, const AxisBank& bank) = 0;
};

/// How to replay.
struct ReplayOptions {
  std::optional<std::uint32_t> threads{};  ///< that step the axes; nothing = as in the journal
  std::uint64_t ticks_a_check = 1;         ///< the check of each n-th tick is compared
  ReplayObserver* observer = nullptr;
};

/// Steps the axes of a journal through what it recorded, as fast as it goes, and compares the check
/// of every tick. No network, no clock.
/// @throws JournalError when the file cannot be read, is damaged, or was written by a program whose
///         state has another layout
[[nodiscard]] ReplayResult replay(const std::filesystem::path& file,
                                  const ReplayOptions& options = {});

/// The same with a journal that is open; messages do not name it.
[[nodiscard]] ReplayResult replay(std::istream& journal, const ReplayOptions& options = {});

}  // namespace vdrive::service

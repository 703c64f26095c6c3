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

/// The result of a replay.
struct ReplayResult {
  bool agrees = true;       ///< all compared checks agree
  bool is_complete = true;  ///< no tick is missing, and the journal has its end mark
  std::string text;         ///< a summary in one line
  std::uint64_t ticks = 0;
  std::uint64_t changes = 0;
};

/// Observes a replay. Each function is called after the step that it reports.
class ReplayObserver {
 public:
  ReplayObserver() = default;
  virtual ~ReplayObserver() = default;
  ReplayObserver(const ReplayObserver&) = delete;
  ReplayObserver& operator=(const ReplayObserver&) = delete;

  /// @param has_authors whether the journal records authors and refusals
  virtual void begins(const Configuration& configuration, bool has_authors) = 0;
  /// All axes now have the state of `snapshot`.
  virtual void restored(const JournalSnapshot& snapshot, const AxisBank& bank) = 0;
  virtual void entered(const JournalChange& change, const AxisBank& bank) = 0;
  virtual void entered(const JournalRefusal& refusal, const AxisBank& bank) = 0;
  virtual void entered(const JournalAuthor& author, const AxisBank& bank) = 0;
  virtual void stepped(std::uint64_t tick, const AxisBank& bank) = 0;
};

struct ReplayOptions {
  std::optional<std::uint32_t> threads{};  ///< that step the axes; nullopt = as in the journal
  std::uint64_t check_interval = 1;        ///< only the check of every n-th tick is compared
  ReplayObserver* observer = nullptr;
};

/// Replays a journal as fast as possible, without network or clock, and compares the recorded
/// checks of the ticks.
/// @throws JournalError when the file cannot be read, is damaged, or was written by a program with
///         a different state layout
[[nodiscard]] ReplayResult replay(const std::filesystem::path& file,
                                  const ReplayOptions& options = {});

/// The same for an open stream; messages do not name the file.
[[nodiscard]] ReplayResult replay(std::istream& journal, const ReplayOptions& options = {});

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

namespace vdrive::client {

/// Detects changes in the presence of services. Time is passed as an argument:
/// wire::Presence::running_time. Not thread-safe.
class ServiceWatch {
 public:
  /// @return the changes since the last call, by bench.
  [[nodiscard]] std::vector<ServiceChange> changes(const Directory& directory,
                                                   Directory::Clock::time_point now);

 private:
  struct Known {
    std::uint64_t incarnation = 0;
    bool is_there = false;
  };

  /// Updates what is known about a bench from one of its runs.
  /// @return the change, if any.
  static std::optional<ServiceNews> note(Known& known, const SeenRun& run);

  /// Forgets benches that the directory no longer knows, to bound the memory.
  void forget_the_unknown(const std::vector<SeenRun>& runs);

  std::map<std::uint32_t, Known> known_;  ///< by bench
};

}  // namespace vdrive::client

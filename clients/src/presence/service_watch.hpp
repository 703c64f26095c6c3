// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

namespace vdrive::client {

/// Finds out what became of services by wire::Presence. Time is an argument. Not
/// thread-safe.
class ServiceWatch {
 public:
  /// @return what has changed since the last call, by bench.
  [[nodiscard]] std::vector<ServiceChange> changes(const Directory& directory,
                                                   Directory::Clock::time_point now);

 private:
  struct Known {
    std::uint64_t incarnation = 0;
    bool is_there = false;
  };

  /// @return what this run of a bench means for what is known of the bench.
  static std::optional<ServiceNews> note(Known& known, const SeenRun& run);

  /// Keeps the memory bounded by that of the directory.
  void forget_the_unknown(const std::vector<SeenRun>& runs);

  std::map<std::uint32_t, Known> known_;  ///< by bench
};

}  // namespace vdrive::client

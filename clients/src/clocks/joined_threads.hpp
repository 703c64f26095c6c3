// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/target.hpp"
#include "vdrive/client/outcome.hpp"

#include <cstdint>
#include <map>
#include <mutex>
#include <utility>

namespace vdrive::client {

/// Which threads of this process have joined clocks, with which sessions. Of two sessions that one
/// thread has joined to a clock the first that steps would wait for the other for ever: the thread
/// waits, and grants nothing. Thread-safe; its lock is held for a few instructions.
class JoinedThreads {
 public:
  /// Notes that the calling thread joins the clock with this session.
  /// @return refused when it has joined the clock with another session.
  [[nodiscard]] Outcome join(const Target& target, std::uint64_t session);

  void leave(const BenchKey& key, std::uint64_t session);

 private:
  std::mutex mutex_;
  std::map<std::pair<BenchKey, std::uint64_t>, std::uint64_t> threads_;  ///< by clock and session
};

/// @return those of this process.
[[nodiscard]] JoinedThreads& joined_threads();

}  // namespace vdrive::client

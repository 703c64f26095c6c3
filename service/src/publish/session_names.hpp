// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/topics.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::service {

/// The programs of the sessions that have acquired axes of a bench, as reported by the programs
/// themselves. Clients do not see each other, so the service of the bench publishes what it has
/// received. Used by one thread.
class SessionNames {
 public:
  /// The maximum number of known sessions; a further one replaces the oldest.
  static constexpr auto kMost = static_cast<std::size_t>(wire::kSessionsOfBench);

  explicit SessionNames(std::uint32_t bench) noexcept : bench_(bench) {}

  /// Keeps a name.
  /// @return whether it is new; false for a name without a session or of another bench
  bool note(const msg::SessionName& name);

  /// @return the oldest unpublished name; nullptr if there is none.
  [[nodiscard]] const msg::BenchSession* next() const noexcept;

  /// Marks the name returned by next() as published.
  void pop() noexcept;

  /// Marks all names as unpublished, for readers that have received none.
  void begin_again();

 private:
  std::uint32_t bench_;
  std::vector<msg::BenchSession> sessions_;  ///< by place
  std::vector<std::uint16_t> unpublished_;   ///< places, each once, the oldest first
  std::size_t oldest_ = 0;                   ///< place that the next new session takes
};

}  // namespace vdrive::service

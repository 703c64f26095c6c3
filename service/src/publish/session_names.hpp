// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/topics.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::service {

/// Who the sessions are that have acquired axes of a bench, as their programs say it. Clients do
/// not see each other, so the service of a bench publishes what it has received. Used by one
/// thread.
class SessionNames {
 public:
  /// So many sessions are known; a further one takes the place of the one that came first.
  static constexpr auto kMost = static_cast<std::size_t>(wire::kSessionsOfBench);

  explicit SessionNames(std::uint32_t bench) noexcept : bench_(bench) {}

  /// Keeps what a program says.
  /// @return whether it is news; what belongs to no session, or to another bench, is none.
  bool note(const msg::SessionName& name);

  /// @return the oldest one that has to be published; nullptr when there is none.
  [[nodiscard]] const msg::BenchSession* next() const noexcept;

  /// That one is published.
  void pop() noexcept;

  /// All have to be published: whoever comes now has received none.
  void begin_again();

 private:
  std::uint32_t bench_;
  std::vector<msg::BenchSession> sessions_;  ///< by place
  std::vector<std::uint16_t> unpublished_;   ///< places, each once, the oldest first
  std::size_t oldest_ = 0;                   ///< place that a further session takes
};

}  // namespace vdrive::service

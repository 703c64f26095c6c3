// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/event.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

namespace vdrive::gateway {

/// The taking of an axis by one session from another.
struct Taking {
  std::uint16_t axis = 0;
  std::uint64_t from = 0;  ///< session that lost it
  std::uint64_t by = 0;    ///< session that took it
  std::uint64_t tick = 0;

  friend bool operator==(const Taking&, const Taking&) = default;
};

/// The recent owners of the axes of one bench, and who took which axis from whom. Thread-safe.
///
/// A program may take an axis and end between two messages to a client. The status does not show
/// that, but the events of the bench do (EVENT_CONTROL_CHANGED).
class OwnerLog {
 public:
  static constexpr std::size_t kMost = 16;  ///< of each; beyond it, the oldest are forgotten

  void note(const client::Observation& observation);

  /// @param event of the bench, in the order reported by the bench
  void note(const client::Event& event);

  /// @return the sessions that hold axes or have held some, the newest last.
  [[nodiscard]] std::vector<std::uint64_t> sessions() const;

  /// @return the axes that were taken, the newest last; without those that a session got back.
  [[nodiscard]] std::vector<Taking> takings() const;

 private:
  void note_session(std::uint64_t session);

  mutable std::mutex mutex_;  ///< guards the members below
  std::deque<std::uint64_t> sessions_;
  std::deque<Taking> lost_;  ///< `by` is not known yet
  std::deque<Taking> takings_;
};

}  // namespace vdrive::gateway

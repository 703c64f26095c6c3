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

/// One axis that a session took from another one.
struct Taking {
  std::uint16_t axis = 0;
  std::uint64_t from = 0;  ///< session that lost it
  std::uint64_t by = 0;    ///< session that took it
  std::uint64_t tick = 0;

  friend bool operator==(const Taking&, const Taking&) = default;
};

/// Who has held the axes of one bench lately, and who took which axis from whom. Any thread.
///
/// A program may take an axis and end between two messages to a client: the status does not show
/// it, the events of the bench do (EVENT_CONTROL_CHANGED).
class OwnerLog {
 public:
  static constexpr std::size_t kMost = 16;  ///< of each; of more, the oldest are forgotten

  void note(const client::Observation& observation);

  /// @param event of the bench, in the order in which the bench reports them
  void note(const client::Event& event);

  /// @return the sessions that hold axes or have held some, the newest last.
  [[nodiscard]] std::vector<std::uint64_t> sessions() const;

  /// @return the axes that were taken, the newest last. What a session got back is not among them.
  [[nodiscard]] std::vector<Taking> takings() const;

 private:
  void note_session(std::uint64_t session);

  mutable std::mutex mutex_;  ///< guards what follows
  std::deque<std::uint64_t> sessions_;
  std::deque<Taking> lost_;  ///< `by` is not known yet
  std::deque<Taking> takings_;
};

}  // namespace vdrive::gateway

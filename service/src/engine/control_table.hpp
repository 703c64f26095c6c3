// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/assert.hpp"
#include "vdrive/wire/conversion.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vdrive::service {

/// The bench's record of a session.
struct SessionRecord {
  std::uint64_t session = 0;
  std::uint32_t epoch = 0;              ///< current epoch, 0 = owns no axis
  std::uint64_t last_message_tick = 0;  ///< last completed tick when its last message arrived
  std::uint64_t last_sequence = 0;      ///< highest sequence number of arrived command frames
  std::uint64_t last_command = 0;  ///< highest sequence number of accepted frames with commands
  std::size_t owned_axes = 0;
  bool must_acquire = false;  ///< it lost axes; a late write must not take them again
};

/// Which session controls which axis. An axis has at most one owner. A session has one current
/// epoch, which is renewed whenever the set of its axes changes; epochs come from one counter of
/// the bench. Fixed size: no allocation after construction.
class ControlTable {
 public:
  static constexpr std::size_t kMaxSessions = 1024;

  explicit ControlTable(std::size_t axes);

  /// @return the record of `session`, or nullptr.
  [[nodiscard]] SessionRecord* find(std::uint64_t session) noexcept;
  [[nodiscard]] const SessionRecord* find(std::uint64_t session) const noexcept;

  /// @return the record of `session` (not 0), created if there is none. A full table forgets the
  ///         session without axes whose last message is the oldest; nullptr if every session owns
  ///         an axis.
  [[nodiscard]] SessionRecord* find_or_add(std::uint64_t session, std::uint64_t tick) noexcept;

  /// Gives the axis, free or owned by another session, to `owner`, and updates the axis count of
  /// the previous owner. Does not renew epochs; call `renew_epoch` afterwards.
  void give(std::size_t axis, SessionRecord& owner) noexcept;

  void take(std::size_t axis) noexcept;

  /// Gives all axes of the session a new epoch; 0 if it owns none.
  void renew_epoch(SessionRecord& record) noexcept;

  [[nodiscard]] const wire::Ownership& owner(std::size_t axis) const noexcept {
    ensure(axis < owners_.size(), "the axis is one of the bench's");
    return owners_[axis];
  }

  [[nodiscard]] std::span<const wire::Ownership> owners() const noexcept { return owners_; }

  /// Notes that a frame of the owner was applied to the axis.
  void set_applied(std::size_t axis, std::uint64_t sequence) noexcept {
    owners_[axis].last_sequence = sequence;
  }

  [[nodiscard]] std::span<SessionRecord> sessions() noexcept { return sessions_; }

 private:
  std::vector<wire::Ownership> owners_;
  std::vector<SessionRecord> sessions_;
  std::uint32_t last_epoch_ = 0;
};

}  // namespace vdrive::service

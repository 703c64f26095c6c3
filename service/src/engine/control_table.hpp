// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/assert.hpp"
#include "vdrive/wire/conversion.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vdrive::service {

/// A client's session as the bench knows it.
struct SessionRecord {
  std::uint64_t session = 0;
  std::uint32_t epoch = 0;              ///< current one, 0 = holds no axis
  std::uint64_t last_message_tick = 0;  ///< last tick completed when a message of it arrived
  std::uint64_t last_sequence = 0;      ///< highest one of the command frames that arrived
  std::uint64_t last_command = 0;       ///< highest one that was accepted and does something
  std::size_t owned_axes = 0;
  bool must_acquire = false;  ///< axes were lost or taken: a late write takes none of them again
};

/// Who is in control of which axis. One owner an axis; epochs come from one counter of the bench,
/// and a session has one current epoch, which every change of what it owns renews. Fixed size: no
/// allocation after construction.
class ControlTable {
 public:
  static constexpr std::size_t kMaxSessions = 1024;

  explicit ControlTable(std::size_t axes);

  /// @return the record of `session`, or nullptr.
  [[nodiscard]] SessionRecord* find(std::uint64_t session) noexcept;
  [[nodiscard]] const SessionRecord* find(std::uint64_t session) const noexcept;

  /// @return the record of `session` (not 0), made when there is none: a full table forgets the
  ///         session without axes whose last message is the oldest; nullptr when every session
  ///         holds an axis.
  [[nodiscard]] SessionRecord* find_or_add(std::uint64_t session, std::uint64_t tick) noexcept;

  /// Gives the free axis, or an axis of another session, to `owner`. The axis count of the previous
  /// owner drops; `renew_epoch` renews the epochs.
  void give(std::size_t axis, SessionRecord& owner) noexcept;

  /// Makes the axis free.
  void take(std::size_t axis) noexcept;

  /// A new epoch for all axes of the session; 0 when it holds none.
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

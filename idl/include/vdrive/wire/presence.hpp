// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/source.hpp"

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

/// The announcement of another participant.
struct OtherParticipant {
  std::string name;
  Source source;
  bool is_closed = false;  ///< it uses DDS Security; see Participant::is_closed()
  std::string place{};     ///< NetworkSettings::place; arbitrary for other programs, may be empty
};

/// Tells which other participants exist, since when, and how certain that is. Over a network, a
/// participant may exist without being known yet, and one that has died may still be known; the
/// samples of a participant show whether it is alive (PresenceByAge). On a local bus exactly the
/// existing participants are known (LocalParticipant). Thread-safe. These functions take no lock
/// other than their own, because handlers call them too.
class Presence {
 public:
  using Clock = std::chrono::steady_clock;

  Presence() = default;
  virtual ~Presence() = default;
  Presence(const Presence&) = delete;
  Presence& operator=(const Presence&) = delete;

  // ---- who is there

  /// @return the other participants known now whose names start with `beginning`. They are known
  ///         before their writers and readers are.
  [[nodiscard]] virtual std::vector<OtherParticipant> others(
      std::string_view beginning = "") const = 0;

  /// @return whether there may be participants that are not known yet. If so, it is worth waiting
  ///         for a search, and a participant missing in `others` may still exist.
  [[nodiscard]] virtual bool may_miss_some() const noexcept = 0;

  /// @return whether this participant certainly exists, whatever its samples show.
  [[nodiscard]] virtual bool is_certain(const Source& source) const noexcept = 0;

  /// @return whether a second service with the same name may appear: it is refused only when the
  ///         two find each other.
  [[nodiscard]] virtual bool may_have_double() const noexcept = 0;

  /// @return whether a participant that has gone may come back: a new one of the same name then
  ///         takes its place.
  [[nodiscard]] virtual bool may_return() const noexcept = 0;

  // ---- since when, not counting times in which this program was stopped

  /// @return for how long this program was stopped between the first call and `now`. A stopped
  ///         program receives nothing, so the silence of the others in that time proves nothing. 0
  ///         if that does not matter.
  [[nodiscard]] virtual Clock::duration own_pauses(Clock::time_point now) = 0;

  /// @return how often to call own_pauses, so that a long gap can only be a pause; nothing if it
  ///         need not be called.
  [[nodiscard]] virtual std::optional<std::chrono::milliseconds> pulse() const noexcept = 0;

  /// @return `now` minus the pauses of this program: the `now` for the functions below.
  [[nodiscard]] Clock::time_point running_time(Clock::time_point now) {
    return now - own_pauses(now);
  }

  /// @param newest_sample when the newest sample of `source` arrived; nothing = none has arrived
  /// @return for how long `source` has given no sign of life; nothing if not known to exist.
  [[nodiscard]] virtual std::optional<Clock::duration> silence(
      const Source& source, std::optional<Clock::time_point> newest_sample,
      Clock::time_point now) const noexcept = 0;

  /// @return whether nobody's silence counts, because the others must first find this program
  ///         again.
  [[nodiscard]] virtual bool is_excused(Clock::time_point now) const = 0;
};

}  // namespace vdrive::wire

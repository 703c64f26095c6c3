// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/source.hpp"

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

/// What another participant announces of itself.
struct OtherParticipant {
  std::string name;
  Source source;
  bool is_closed = false;  ///< it has DDS Security: only participants of its closed mode meet it
  std::string place{};  ///< NetworkSettings::place; anything of a stranger, empty where it has none
};

/// Who else is there, since when, and how certain that is. Over a network a participant that is
/// there may not be known yet, and one that has died still is: its samples show whether it is there
/// (PresenceByAge). On a local bus those that are there are known, each as long as it lives. Both
/// answer the same questions. Thread-safe; an answer takes no lock but its own: handlers ask, too.
class Presence {
 public:
  using Clock = std::chrono::steady_clock;

  Presence() = default;
  virtual ~Presence() = default;
  Presence(const Presence&) = delete;
  Presence& operator=(const Presence&) = delete;

  // ---- who is there

  /// @return the other participants that are known now and have a name with this beginning. They
  ///         are known before their writers and readers are.
  [[nodiscard]] virtual std::vector<OtherParticipant> others(
      std::string_view beginning = "") const = 0;

  /// @return whether some may be there that are not known yet: then a search is worth waiting for,
  ///         and one that is not among `others` may be there all the same.
  [[nodiscard]] virtual bool may_miss_some() const noexcept = 0;

  /// @return whether this participant is there for certain, whatever its samples show.
  [[nodiscard]] virtual bool is_certain(const Source& source) const noexcept = 0;

  /// @return whether a second service may come that has the name of the first: it is refused only
  ///         when the two hear of each other.
  [[nodiscard]] virtual bool may_have_double() const noexcept = 0;

  /// @return whether one that has gone may come back: what comes with its name continues it.
  [[nodiscard]] virtual bool may_return() const noexcept = 0;

  // ---- since when: in times in which this program ran

  /// @return how long this program was stopped between the first call and `now`. While stopped it
  ///         receives nothing, which says nothing about others. 0 where that does not matter.
  [[nodiscard]] virtual Clock::duration own_pauses(Clock::time_point now) = 0;

  /// @return how often own_pauses has to be called, so that a long gap can only be a pause; nothing
  /// = it need
  ///         not be called.
  [[nodiscard]] virtual std::optional<std::chrono::milliseconds> pulse() const noexcept = 0;

  /// @return `now` without the pauses of this program: the time of the following questions.
  [[nodiscard]] Clock::time_point running_time(Clock::time_point now) {
    return now - own_pauses(now);
  }

  /// @param newest_sample of this participant, nothing = none has arrived
  /// @return for how long it has not shown that it is there; nothing when it is not, as far as is
  ///         known.
  [[nodiscard]] virtual std::optional<Clock::duration> silence(
      const Source& source, std::optional<Clock::time_point> newest_sample,
      Clock::time_point now) const noexcept = 0;

  /// @return whether nobody's silence counts: the others first have to find this program again.
  [[nodiscard]] virtual bool is_excused(Clock::time_point now) const = 0;
};

}  // namespace vdrive::wire

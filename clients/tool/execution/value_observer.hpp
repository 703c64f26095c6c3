// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::tool {

/// Observes one object of an axis in tick after tick, from the tick on in which the last write is
/// in force.
class ValueObserver {
 public:
  ValueObserver(client::Session& session, client::Axis& axis, ObjectAddress object)
      : session_(session), axis_(axis), object_(object) {}

  /// The first observation. @param in_force the earliest tick that counts
  client::Outcome start(const client::BenchInfo& bench, std::uint64_t in_force);

  /// Observes the next tick.
  client::Outcome next();

  /// @return whether every tick of realtime can be observed: the status stream has the object.
  [[nodiscard]] bool sees_every_tick() const { return is_lockstep_ || is_streamed_; }

  [[nodiscard]] std::uint64_t tick() const { return tick_; }

  /// The same without the ticks that the number jumped over: for durations.
  [[nodiscard]] std::uint64_t driven_tick() const { return shown_.driven_tick(); }

  /// The axis as it was last observed.
  [[nodiscard]] const client::AxisSnapshot& shown() const { return shown_; }

  [[nodiscard]] std::int64_t value() const { return value_; }

  /// Samples of the stream lost since the first observation.
  [[nodiscard]] std::uint64_t missed() const { return missed_; }

 private:
  client::Outcome see(client::Result<client::Observation> sample);

  client::Session& session_;
  client::Axis& axis_;
  ObjectAddress object_;
  std::optional<client::Follower> follower_;
  bool is_lockstep_ = false;
  bool is_streamed_ = false;
  std::uint64_t tick_ = 0;
  std::uint64_t missed_ = 0;
  std::int64_t value_ = 0;
  client::AxisSnapshot shown_;
};

}  // namespace vdrive::tool

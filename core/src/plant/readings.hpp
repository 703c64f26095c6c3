// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "plant/effects.hpp"
#include "plant/servo_block.hpp"
#include "rounding.hpp"

#include <cstddef>

namespace vdrive {

// Position of the load of a lane and readings of its encoders at any sub-step. Inline because the
// hot loops use them too.

[[gnu::always_inline]] inline double quantise(double x, double per_unit, double unit) {
  return nearest(x * per_unit) * unit;
}

/// Computes the load position of a rigid axis. On an elastic shaft it is part of the model.
[[gnu::always_inline]] inline void place_load(const RigidParameters& p, ServoState& s,
                                              std::size_t l) {
  s.load_position[l] = p.loop.ratio[l] * s.position[l] + s.load_offset[l];
}

[[gnu::always_inline]] inline void place_load(const ElasticParameters& /*p*/, ServoState& /*s*/,
                                              std::size_t /*l*/) {}

/// @return `position` as encoder 1 sees it; `e` is null where no lane has an effect.
template <bool kEffects>
[[gnu::always_inline]] inline double seen_by_motor(const EffectBlock* e, std::size_t l,
                                                   double position) {
  return kEffects ? position + e->state.motor_noise[l] : position;
}

/// @return `position` as the encoder of the position loop sees it.
template <bool kEffects>
[[gnu::always_inline]] inline double seen_by_load(const EffectBlock* e, std::size_t l,
                                                  double position) {
  return kEffects ? position + e->state.load_noise[l] : position;
}

/// The encoder readings of a lane.
struct EncoderReadings {
  double motor;  // encoder 1 [UU]
  double load;   // the encoder of the position loop [UU]
};

/// Call after place_load.
template <bool kEffects>
[[gnu::always_inline]] inline EncoderReadings read_lane(const LoopParameters& p,
                                                        const ServoState& s, const EffectBlock* e,
                                                        std::size_t l) {
  const double position = p.closes_on_load[l] != 0.0 ? s.load_position[l] : s.position[l];
  return {quantise(seen_by_motor<kEffects>(e, l, s.position[l]), p.counts_per_unit[l],
                   p.units_per_count[l]),
          quantise(seen_by_load<kEffects>(e, l, position), p.load_counts_per_unit[l],
                   p.load_units_per_count[l])};
}

}  // namespace vdrive

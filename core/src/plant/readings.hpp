// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "plant/effects.hpp"
#include "plant/servo_block.hpp"
#include "rounding.hpp"

#include <cstddef>

namespace vdrive {

// Where the load of a lane is and what its encoders read, at any sub-step. In the header, because
// the hot loops ask for it, too.

[[gnu::always_inline]] inline double quantise(double x, double per_unit, double unit) {
  return nearest(x * per_unit) * unit;
}

/// Load of a rigid axis; a load on a shaft has its position from the model.
[[gnu::always_inline]] inline void place_load(const RigidParameters& p, ServoState& s,
                                              std::size_t l) {
  s.load_position[l] = p.loop.ratio[l] * s.position[l] + s.load_offset[l];
}

[[gnu::always_inline]] inline void place_load(const ElasticParameters& /*p*/, ServoState& /*s*/,
                                              std::size_t /*l*/) {}

/// @return where encoder 1 sees `position`; `e` is null where no lane has an effect.
template <bool kEffects>
[[gnu::always_inline]] inline double seen_by_motor(const EffectBlock* e, std::size_t l,
                                                   double position) {
  return kEffects ? position + e->state.motor_noise[l] : position;
}

/// @return where the encoder of the position loop sees `position`.
template <bool kEffects>
[[gnu::always_inline]] inline double seen_by_load(const EffectBlock* e, std::size_t l,
                                                  double position) {
  return kEffects ? position + e->state.load_noise[l] : position;
}

/// What the encoders of a lane read.
struct EncoderReadings {
  double motor;  // encoder 1 [UU]
  double load;   // the encoder of the position loop [UU]
};

/// Once the load has its place.
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

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lanes.hpp"
#include "plant/servo_block.hpp"
#include "plant/servo_design.hpp"
#include "rounding.hpp"
#include "vdrive/plant/axis_model.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdrive {

/// What the effects of a block are: holding brake, cogging, torque ripple, encoder noise, end stops
/// and heat of the motor. In a lane without an effect its numbers change no bit.
struct alignas(64) EffectParameters {
  Lane cogging;        // at a quarter of a period, <= 0: a period begins where it pulls to [UU/s²]
  Lane cogging_turns;  // periods of the cogging [1/UU] of the motor
  Lane ripple;         // largest part of the torque [1]
  Lane ripple_turns;   // periods of the ripple [1/UU] of the motor
  Lane brake;          // Coulomb friction of the closed brake [UU/s²]
  Lane brake_impulse;  // its effect on the velocity of a sub-step [UU/s]
  Lane release_ticks;  // from power on to the open brake
  Lane engage_ticks;   // from power off to the closed brake
  Lane lower_stop;     // of the load, as counted at first power-up; -infinity = none [UU]
  Lane upper_stop;     // of the load, as counted at first power-up; infinity = none [UU]
  Lane motor_per_load;    // motor over load revolutions
  Lane motor_noise;       // encoder 1, root mean square [UU]
  Lane load_noise;        // encoder of the position loop, root mean square [UU]
  Lane shares_encoder;    // 1 = the position loop uses encoder 1
  Lane heat_gain;         // part of its way that the heat goes in a tick; 0 = no heat
  std::uint64_t cogged;   // lanes with cogging
  std::uint64_t rippled;  // lanes with ripple
  std::uint64_t stopped;  // lanes with an end stop
  std::array<std::uint64_t, 5> unused;
};

/// State of the effects of a block.
struct alignas(64) EffectState {
  Lane brake;          // Coulomb friction of the brake as it is now, 0 = open or none [UU/s²]
  Lane brake_impulse;  // its effect on the velocity of a sub-step [UU/s]
  Lane powered;        // ServoState::powered of the last tick
  Lane brake_ticks;    // since the power stage was switched, at most until the brake has followed
  Lane motor_origin;   // 0 of the first power-up, in the frame of the motor [UU]
  Lane lower_stop;     // in the frame of the load [UU]
  Lane upper_stop;     // in the frame of the load [UU]
  Lane motor_noise;    // of encoder 1 at this instant [UU]
  Lane load_noise;     // of the encoder of the position loop at this instant [UU]
  Lane heat;           // of the motor, over that which the rated current makes for ever
  std::array<std::uint64_t, kLanes> streams;  // of seed and axis
  std::uint64_t draws;                        // of encoder noise, two each sub-step
  std::uint64_t noisy;                        // lanes with encoder noise
  std::uint64_t hot;                          // lanes above the rated heat
  std::uint64_t following;                    // lanes whose brake may change without a switch
  std::array<std::uint64_t, 4> unused;
};

/// The effects of a block whose axes have any.
struct alignas(64) EffectBlock {
  EffectParameters parameters;
  EffectState state;
};

/// Sine of `turns` revolutions, made of two parabolas: exact at every quarter of a turn, at most
/// 0.0011 wrong between. |turns| < 2⁵¹.
[[nodiscard, gnu::always_inline]] inline double sine_of_turns(double turns) noexcept {
  const double part = turns - nearest(turns);
  const double arc = part * (8.0 - 16.0 * std::abs(part));
  return arc * (0.775 + 0.225 * std::abs(arc));
}

/// @return a block in which no lane has an effect.
[[nodiscard]] EffectBlock no_effects() noexcept;

/// What the effects of an axis depend on beside its model and gear.
struct EffectDesign {
  double period;              // of a tick [s]
  double velocity_from_load;  // effect of 1 UU/s² at the motor on the velocity of a sub-step [s]
};

/// Fills one lane; its brake takes the new values in the next tick.
void design_effects(const AxisModel& model, const Gear& gear, const EffectDesign& design,
                    std::size_t lane, EffectBlock& block) noexcept;

/// A lane that is filled begins: its brake is closed, its noise depends on the model's seed and
/// `axis`.
void start_effects(const AxisModel& model, std::uint64_t axis, std::size_t lane,
                   EffectBlock& block) noexcept;

/// Where the frames of an axis count from: the place that was 0 at first power-up [UU].
struct Origins {
  double motor = 0.0;
  double load = 0.0;
};

/// Puts the periods of the motor and the end stops of one lane into the frames of now.
void place_effects(EffectBlock& block, std::size_t lane, const Origins& origins) noexcept;

/// Before the sub-steps of a tick: the brakes follow the power stages.
void move_brakes(EffectBlock& block, const ServoState& servo) noexcept;

/// After them: the heat follows the squares of the currents.
/// @param current_per_mille 6078h of one torque unit, by lane
void heat_motors(EffectBlock& block, const ServoState& servo,
                 const Lane& current_per_mille) noexcept;

/// @return the lanes whose heat is above `heat`.
[[nodiscard]] std::uint64_t lanes_hotter(const EffectState& state, double heat) noexcept;

}  // namespace vdrive

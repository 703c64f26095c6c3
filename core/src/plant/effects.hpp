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

/// Parameters of the effects of a block: holding brake, cogging, torque ripple, encoder noise, end
/// stops and motor heat. In a lane without an effect, the parameters of that effect change no bit.
struct alignas(64) EffectParameters {
  Lane cogging;           // at a quarter period [UU/s²]; <= 0, as periods start at stable detents
  Lane cogging_turns;     // periods of the cogging [1/UU] of the motor
  Lane ripple;            // peak fraction of the torque [1]
  Lane ripple_turns;      // periods of the ripple [1/UU] of the motor
  Lane brake;             // Coulomb friction of the closed brake [UU/s²]
  Lane brake_impulse;     // change of velocity that it causes in a sub-step [UU/s]
  Lane release_ticks;     // from power on until the brake is open
  Lane engage_ticks;      // from power off until the brake is closed
  Lane lower_stop;        // of the load, as counted at first power-up; -infinity = none [UU]
  Lane upper_stop;        // of the load, as counted at first power-up; infinity = none [UU]
  Lane motor_per_load;    // motor over load revolutions
  Lane motor_noise;       // encoder 1, root mean square [UU]
  Lane load_noise;        // encoder of the position loop, root mean square [UU]
  Lane shares_encoder;    // 1 = the position loop uses encoder 1
  Lane heat_gain;         // fraction of the heat's step response in a tick; 0 = no heating
  std::uint64_t cogged;   // lanes with cogging
  std::uint64_t rippled;  // lanes with ripple
  std::uint64_t stopped;  // lanes with an end stop
  std::array<std::uint64_t, 5> unused;
};

/// State of the effects of a block.
struct alignas(64) EffectState {
  Lane brake;          // present Coulomb friction of the brake, 0 = open or none [UU/s²]
  Lane brake_impulse;  // change of velocity that it causes in a sub-step [UU/s]
  Lane powered;        // ServoState::powered of the last tick
  Lane brake_ticks;    // since the power stage was switched, until the brake has followed
  Lane motor_origin;   // Origins::motor [UU]
  Lane lower_stop;     // in the frame of the load [UU]
  Lane upper_stop;     // in the frame of the load [UU]
  Lane motor_noise;    // of encoder 1 now [UU]
  Lane load_noise;     // of the encoder of the position loop now [UU]
  Lane heat;           // of the motor, relative to the steady state at rated current
  std::array<std::uint64_t, kLanes> streams;  // from seed and axis
  std::uint64_t draws;                        // of encoder noise, two per sub-step
  std::uint64_t noisy;                        // lanes with encoder noise
  std::uint64_t hot;                          // lanes above the rated heat
  std::uint64_t following;  // lanes whose brake may change though the power stage does not
  std::array<std::uint64_t, 4> unused;
};

/// The effects of a block in which at least one axis has one.
struct alignas(64) EffectBlock {
  EffectParameters parameters;
  EffectState state;
};

/// Sine of `turns` revolutions, approximated by two parabolas: exact at every quarter turn, with an
/// error of at most 0.0011 in between. |turns| < 2⁵¹.
[[nodiscard, gnu::always_inline]] inline double sine_of_turns(double turns) noexcept {
  const double part = turns - nearest(turns);
  const double arc = part * (8.0 - 16.0 * std::abs(part));
  return arc * (0.775 + 0.225 * std::abs(arc));
}

/// @return a block in which no lane has an effect.
[[nodiscard]] EffectBlock no_effects() noexcept;

/// The inputs of an axis's effects, apart from its model and gear.
struct EffectDesign {
  double period;              // of a tick [s]
  double velocity_from_load;  // change of velocity in a sub-step per UU/s² at the motor [s]
};

/// Fills one lane; its brake takes the new values in the next tick.
void design_effects(const AxisModel& model, const Gear& gear, const EffectDesign& design,
                    std::size_t lane, EffectBlock& block) noexcept;

/// Starts a filled lane: its brake is closed; its noise depends on the seed of the model and on
/// `axis`.
void start_effects(const AxisModel& model, std::uint64_t axis, std::size_t lane,
                   EffectBlock& block) noexcept;

/// The present positions, in their frames, of the points that were at 0 at first power-up [UU].
struct Origins {
  double motor = 0.0;
  double load = 0.0;
};

/// Moves the cogging and ripple periods and the end stops of one lane into the present frames.
void place_effects(EffectBlock& block, std::size_t lane, const Origins& origins) noexcept;

/// Before the sub-steps of a tick: makes the brakes follow the power stages.
void move_brakes(EffectBlock& block, const ServoState& servo) noexcept;

/// After the sub-steps: makes the heat follow the squares of the currents.
/// @param current_per_mille 6078h at a torque of 1 UU/s² [‰], by lane
void heat_motors(EffectBlock& block, const ServoState& servo,
                 const Lane& current_per_mille) noexcept;

/// @return the lanes whose heat is above `heat`.
[[nodiscard]] std::uint64_t lanes_hotter(const EffectState& state, double heat) noexcept;

}  // namespace vdrive

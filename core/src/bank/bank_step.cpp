// SPDX-License-Identifier: Apache-2.0
#include "bank/bank_state.hpp"
#include "drive/block.hpp"
#include "drive/demand.hpp"
#include "drive/faults.hpp"
#include "drive/modulo.hpp"
#include "drive/tick.hpp"
#include "drive/touch_probe.hpp"
#include "plant/effects.hpp"
#include "plant/load_noise.hpp"
#include "plant/readings.hpp"
#include "plant/servo_block.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

namespace vdrive {

namespace {

std::uint64_t all_lanes(const Block& block) {
  return (std::uint64_t{1} << block.count) - 1U;
}

/// @return whether no axis of the block has noise and each one is on its target or has no power.
bool rests(const Block& block) {
  const SteadyBlock& steady = block.state.steady;
  return block.state.noisy == 0 && (steady.standing | steady.unpowered) == all_lanes(block);
}

/// @return whether a tick could leave `servo` unchanged.
bool may_stand_still(const ServoState& servo) {
  return std::ranges::all_of(servo.velocity, [](double velocity) {
    return velocity == 0.0;
  });
}

/// State of a block before a tick, to detect that the tick changes nothing.
struct TickStart {
  ServoState servo;
  EffectState effects;
};

void note_start(const ServoState& servo, const EffectBlock* effects, TickStart& start) {
  start.servo = servo;
  if (effects != nullptr) start.effects = effects->state;
}

/// @return whether the tick has left every bit unchanged.
bool stands_as(const TickStart& start, const ServoState& servo, const EffectBlock* effects) {
  return alike(start.servo, servo) && (effects == nullptr || alike(start.effects, effects->state));
}

template <typename Visit>
void for_each_lane(std::uint64_t lanes, Visit visit) {
  for (; lanes != 0; lanes &= lanes - 1U) visit(static_cast<std::size_t>(std::countr_zero(lanes)));
}

}  // namespace

void AxisBank::State::end_settled(std::size_t block) {
  BlockState& state = blocks[block].state;
  state.ticks += settled[block].ticks;
  for_each_lane(state.steady.standing, [&](std::size_t lane) {
    state.demand.plan_ticks[lane] += static_cast<double>(settled[block].ticks);
  });
  settled[block] = {};
}

void AxisBank::State::end_steadiness(std::size_t block, std::uint64_t lanes) {
  if (settled[block].is_settled != 0) end_settled(block);
  for_each_lane(lanes, [this, block](std::size_t lane) {
    Drive drive = this->drive(block, lane);
    vdrive::end_steadiness(drive);
  });
}

void AxisBank::State::draw_loads(const Block& block) {
  for_each_lane(block.state.noisy, [&](std::size_t lane) {
    const std::uint32_t axis = block.axes[lane];
    drive(axis).servo().load_torque[lane] = next_load(noises[axis]);
  });
}

void AxisBank::State::begin_effects(std::size_t block_index, std::uint64_t moved) {
  const Block& block = blocks[block_index];
  EffectBlock& of_block = effects[block.effects];
  for_each_lane(moved, [&](std::size_t lane) {
    const FrameOrigins& origins = drive(block_index, lane).registers().origins;
    place_effects(of_block, lane, {.motor = origins.motor, .load = origins.load});
  });
  move_brakes(of_block, block.state.servo);
}

std::uint64_t AxisBank::State::end_effects(std::size_t block_index) {
  const Block& block = blocks[block_index];
  EffectBlock& of_block = effects[block.effects];
  heat_motors(of_block, block.state.servo, block.state.units.current_per_mille);
  const std::uint64_t hot = lanes_hotter(of_block.state, kWarningHeat) & all_lanes(block);
  std::uint64_t changed = 0;
  for_each_lane(hot | of_block.state.hot, [&](std::size_t lane) {
    Drive drive = this->drive(block_index, lane);
    if (note_heat(drive, of_block.state.heat[lane])) changed |= std::uint64_t{1} << lane;
  });
  of_block.state.hot = hot;
  return changed;
}

TickLanes AxisBank::State::begin_block(std::size_t block_index) {
  Block& block = blocks[block_index];
  ensure(block.count > 0, "a block has an axis");
  const DemandBlock& demand = block.state.demand;
  const std::uint64_t all = all_lanes(block);
  TickLanes lanes{.steady = block.state.steady.lanes & ~lanes_out_of_frame(demand) & all};
  const std::uint64_t out_of_frame = block.state.steady.lanes & ~lanes.steady;
  if (out_of_frame != 0) end_steadiness(block_index, out_of_frame);
  for_each_lane(all & ~lanes.steady, [this, block_index](std::size_t lane) {
    Drive drive = this->drive(block_index, lane);
    begin_tick(drive);
  });
  draw_loads(block);
  if (block.effects != kNoEffects) begin_effects(block_index, all & ~lanes.steady);
  lanes.across = lanes_across(demand, timing) & all;
  return lanes;
}

std::size_t AxisBank::State::cross_segments(const Batch& batch, std::size_t substep,
                                            std::span<const TickLanes> lanes) {
  std::size_t last = timing.substeps;
  for (std::size_t i = 0; i < batch.count; ++i) {
    for_each_lane(lanes[i].across, [&](std::size_t lane) {
      Drive drive = this->drive(batch.blocks[i], lane);
      last = std::min(last, vdrive::cross_segments(drive, substep));
    });
  }
  return last;
}

template <typename Parameters>
void AxisBank::State::evaluate_probes(const ParameterPool<Parameters>& pool, const Batch& batch,
                                      std::size_t substep) {
  constexpr std::uint64_t kNanosecondsAMicrosecond = 1000;
  const std::uint64_t tick_ns = timing.period_us * kNanosecondsAMicrosecond;
  for (std::size_t i = 0; i < batch.count; ++i) {
    Block& block = blocks[batch.blocks[i]];
    if (block.state.probed == 0) continue;
    const Parameters& parameters = pool.get(block.pool_index);
    ServoState& servo = block.state.servo;
    const std::uint64_t time_ns = block.state.ticks * tick_ns + substep * tick_ns / timing.substeps;
    const EffectBlock* const of_block = effects_of(block);
    for_each_lane(block.state.probed, [&](std::size_t lane) {
      place_load(parameters, servo, lane);
      const EncoderReadings readings =
          of_block == nullptr ? read_lane<false>(parameters.loop, servo, of_block, lane)
                              : read_lane<true>(parameters.loop, servo, of_block, lane);
      Drive drive = this->drive(batch.blocks[i], lane);
      evaluate_inputs(
          drive,
          {.motor_reading = readings.motor, .position_reading = readings.load, .time_ns = time_ns});
    });
  }
}

template <typename Parameters>
void AxisBank::State::step_pieces(const ParameterPool<Parameters>& pool, const Batch& batch,
                                  std::span<const TickLanes> lanes, ServoFeatures features) {
  std::array<ServoBlock<Parameters>, kInterleavedBlocks> servo_blocks{};
  std::uint64_t across = 0;
  std::uint64_t probed = 0;
  for (std::size_t i = 0; i < batch.count; ++i) {
    Block& block = blocks[batch.blocks[i]];
    across |= lanes[i].across;
    probed |= block.state.probed;
    servo_blocks[i] = {&pool.get(block.pool_index), &block.state.demand, &block.state.servo,
                       effects_of(block)};
  }
  const std::span<const ServoBlock<Parameters>> work(servo_blocks.data(), batch.count);
  if (probed != 0) evaluate_probes(pool, batch, 0);
  for (std::size_t first = 0; first < timing.substeps;) {
    std::size_t last = across == 0 ? timing.substeps : cross_segments(batch, first, lanes);
    if (probed != 0) last = first + 1;
    step_servo(work, {first, last, static_cast<double>(timing.substeps), timing.substep}, features);
    if (probed != 0) evaluate_probes(pool, batch, last);
    first = last;
  }
}

void AxisBank::State::end_block(std::size_t block_index, const TickLanes& lanes) {
  Block& block = blocks[block_index];
  const std::uint64_t changed = block.effects == kNoEffects ? 0U : end_effects(block_index);
  const std::uint64_t unpowered = lanes.steady & block.state.steady.unpowered & ~changed;
  const std::uint64_t holding = lanes.steady & ~unpowered & ~changed;
  if (unpowered != 0) rest_at_load(block.state.demand, block.state.servo, unpowered);
  const std::uint64_t steady =
      unpowered | (holding != 0 ? end_steady_tick(block.state, holding, timing) : 0U);
  const std::uint64_t ended = lanes.steady & ~steady;
  if (ended != 0) end_steadiness(block_index, ended);
  const std::uint64_t others = all_lanes(block) & ~steady;
  for_each_lane(others, [this, block_index](std::size_t lane) {
    Drive drive = this->drive(block_index, lane);
    watch_tick(drive);
  });
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): filled by the next statement
  NumberBlock numbers;
  round_numbers(block.state, numbers);
  for_each_lane(block.state.modulo, [&](std::size_t lane) {
    fold_numbers(this->drive(block_index, lane), numbers);
  });
  for_each_lane(block.state.frozen, [&](std::size_t lane) {
    freeze_feedback(this->drive(block_index, lane), numbers);
  });
  for_each_lane(steady, [&](std::size_t lane) {
    show_numbers(numbers, lane, statuses[block.axes[lane]]);
  });
  for_each_lane(others, [&](std::size_t lane) {
    Drive drive = this->drive(block_index, lane);
    end_tick(drive, numbers);
  });
}

template <typename Parameters>
void AxisBank::State::step_batch(const ParameterPool<Parameters>& pool, const Batch& batch) {
  std::array<TickLanes, kInterleavedBlocks> lanes{};
  ServoFeatures features;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): filled where it is read
  std::array<TickStart, kInterleavedBlocks> starts;
  std::array<bool, kInterleavedBlocks> may_settle{};
  features.effects = batch.has_effects;
  for (std::size_t i = 0; i < batch.count; ++i) {
    Block& block = blocks[batch.blocks[i]];
    may_settle[i] = rests(block) && may_stand_still(block.state.servo);
    if (may_settle[i]) note_start(block.state.servo, effects_of(block), starts[i]);
    lanes[i] = begin_block(batch.blocks[i]);
    features.general = features.general || !is_plain(block.state.servo);
    features.play = features.play || block.has_play;
    features.jerk = features.jerk || block.state.jerk_limited != 0;
  }
  step_pieces(pool, batch, lanes, features);
  for (std::size_t i = 0; i < batch.count; ++i) {
    Block& block = blocks[batch.blocks[i]];
    ++block.state.ticks;
    end_block(batch.blocks[i], lanes[i]);
    const bool is_settled =
        may_settle[i] && stands_as(starts[i], block.state.servo, effects_of(block));
    ensure(!is_settled || rests(block), "an axis whose servo does not change keeps resting");
    settled[batch.blocks[i]].is_settled = is_settled ? 1U : 0U;
  }
}

void AxisBank::State::step_batch(const Batch& batch) {
  if (batch.count == 0) return;
  if (batch.coupling == Coupling::rigid) {
    step_batch(rigid, batch);
  } else {
    step_batch(elastic, batch);
  }
}

void AxisBank::State::step_blocks(std::size_t first, std::size_t last) {
  Batch batch;
  for (; first < last; ++first) {
    if (settled[first].is_settled != 0) {
      ++settled[first].ticks;
      continue;
    }
    const Coupling coupling = blocks[first].coupling;
    const bool has_effects = blocks[first].effects != kNoEffects;
    if (batch.count == kInterleavedBlocks || batch.coupling != coupling ||
        batch.has_effects != has_effects) {
      step_batch(batch);
      batch = {.coupling = coupling, .has_effects = has_effects};
    }
    batch.blocks[batch.count] = first;
    ++batch.count;
  }
  step_batch(batch);
}

}  // namespace vdrive

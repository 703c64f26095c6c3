// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bank/parameter_memory.hpp"
#include "bank/parameter_pool.hpp"
#include "drive/registers.hpp"
#include "drive/state.hpp"
#include "plant/effects.hpp"
#include "plant/load_noise.hpp"
#include "plant/servo_block.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/axis_bank.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace vdrive {

/// Value of Block::effects if no axis of the block has effects (plant/effects.hpp).
inline constexpr std::uint32_t kNoEffects = 0xFFFF'FFFF;

/// Up to kLanes axes of one coupling, stepped together; see drive/block.hpp.
struct Block {
  BlockState state{};
  Coupling coupling = Coupling::rigid;
  std::uint32_t pool_index = 0;  // index among the blocks of this coupling
  std::uint32_t count = 0;
  std::uint32_t effects = kNoEffects;        // index among the blocks with effects
  bool has_play = false;                     // a lane has backlash
  std::array<std::uint32_t, kLanes> axes{};  // by lane, `count` of them
};

/// Blocks of one coupling that are stepped together, either all with effects or all without.
struct Batch {
  Coupling coupling = Coupling::rigid;
  bool has_effects = false;
  std::size_t count = 0;  // up to kInterleavedBlocks
  std::array<std::size_t, kInterleavedBlocks> blocks{};
};

/// After a tick that left every bit of a block unchanged, the next one would do the same. Further
/// ticks are skipped until something is written to an axis of the block.
struct Settled {
  std::uint64_t is_settled = 0;  // 0 or 1
  std::uint64_t ticks = 0;       // skipped so far; they count as time on the target
};

/// Lanes of a block in a tick.
struct TickLanes {
  std::uint64_t steady = 0;  // SteadyBlock::lanes at the start of the tick
  std::uint64_t across = 0;  // the tick crosses a border between two segments
};

/// The block and lane of an axis.
struct Place {
  std::uint32_t block = 0;
  std::uint32_t lane = 0;
};

static_assert(std::is_trivially_copyable_v<BlockState>);
static_assert(std::is_trivially_copyable_v<Settled>);
static_assert(std::is_trivially_copyable_v<DriveState>);
static_assert(std::is_trivially_copyable_v<DriveRegisters>);
static_assert(std::is_trivially_copyable_v<AxisStatus>);
static_assert(std::is_trivially_copyable_v<LoadNoise>);

/// The complete state of a bank. Its parts are implemented in separate files.
struct AxisBank::State {
  TickTiming timing;
  std::vector<AxisConfiguration> configurations;
  std::vector<Place> places;  // by axis
  std::vector<Block> blocks;
  ParameterPool<RigidParameters> rigid;
  ParameterPool<ElasticParameters> elastic;
  std::vector<Settled> settled;                 // by block
  std::vector<DriveState> drive_states;         // by block and lane
  std::vector<DriveRegisters> drive_registers;  // by block and lane
  std::vector<AxisStatus> statuses;             // by axis
  std::vector<ParameterMemory> memories;        // by axis
  std::vector<LoadNoise> noises;                // by axis
  std::vector<EffectBlock> effects;             // of the blocks that have effects

  [[nodiscard]] Drive drive(std::size_t block, std::size_t lane) {
    const std::size_t slot = block * kLanes + lane;
    return {drive_states[slot],
            drive_registers[slot],
            blocks[block].state,
            lane,
            statuses[blocks[block].axes[lane]],
            timing};
  }

  [[nodiscard]] Drive drive(std::size_t axis) {
    ensure(axis < places.size(), "the axis is one of the bank's");
    return drive(places[axis].block, places[axis].lane);
  }

  /// @return the axis, for a change from outside: its next tick runs all checks.
  [[nodiscard]] Drive changed_drive(std::size_t axis) {
    ensure(axis < places.size(), "the axis is one of the bank's");
    end_steadiness(places[axis].block, std::uint64_t{1} << places[axis].lane);
    return drive(axis);
  }

  // bank_snapshot.cpp

  /// Passes each array of plain data that is part of the state to `visit(first, count)`, in a fixed
  /// order. Data derived from the configuration is left out.
  template <typename Visit>
  void for_each_part(Visit visit);
  /// Checks state that was read from a file.
  /// @return whether its pool indexes, modes, homing methods, segment counts and sets of lanes are
  ///         valid.
  [[nodiscard]] bool is_sound() const;

  // bank_blocks.cpp: assigns axes to lanes of blocks

  void place_axes(Coupling coupling);
  void design_blocks();
  void add_effects();

  /// @return the effects of a block, or nullptr.
  [[nodiscard]] EffectBlock* effects_of(const Block& block) {
    return block.effects == kNoEffects ? nullptr : &effects[block.effects];
  }

  // bank_values.cpp: registers and their stored values

  /// @throws std::invalid_argument when an initial or stored value is refused
  void start_axis(std::size_t axis);

  /// Sets the configured values, then the stored ones.
  /// @return the first initial value that was refused, or nullptr.
  const InitialValue* set_initial_values(std::size_t axis);
  void fill_memory(std::size_t axis);
  AbortCode write(std::size_t axis, ObjectRow row, std::int64_t value);

  // bank_tuning.cpp: effect of objects on the servo

  /// 3576h and 3577h: applies the gear to the load, the loops and the torques.
  void apply_gear(std::size_t axis);
  /// Applies 6072h, 60E0h, 60E1h, 6075h, 6076h and the load torque, through the present gear.
  void apply_torques(std::size_t axis);
  /// Recomputes the effects of an axis for `gear`; does nothing if its block has no effects.
  void design_effects(std::size_t axis, const Gear& gear);

  // bank_step.cpp: one tick

  /// Makes a settled block compute its next tick again.
  void end_settled(std::size_t block);

  /// Makes the next step run the full tick for these lanes of a block.
  void end_steadiness(std::size_t block, std::uint64_t lanes);

  /// Draws the load torque of this tick for the axes of a block that have noise.
  void draw_loads(const Block& block);

  /// Runs the part of the effects that precedes the servo step.
  /// @param moved lanes whose position frames (drive/frame.hpp) may have been shifted
  void begin_effects(std::size_t block, std::uint64_t moved);

  /// Updates the heat of the motors of a block with effects.
  /// @return the lanes whose load level has changed: their tick is not a steady one.
  std::uint64_t end_effects(std::size_t block);

  /// Runs the part of the tick that precedes the servo step.
  TickLanes begin_block(std::size_t block);

  /// Loads the segments valid at `substep` into the lanes that cross a border.
  /// @return the sub-step up to which all of them are valid.
  std::size_t cross_segments(const Batch& batch, std::size_t substep,
                             std::span<const TickLanes> lanes);

  /// Evaluates the inputs of the axes with an enabled touch probe, at the start of the sub-step.
  template <typename Parameters>
  void evaluate_probes(const ParameterPool<Parameters>& pool, const Batch& batch,
                       std::size_t substep);

  /// Runs the servo step of a tick, in pieces if a lane crosses a border or a touch probe is
  /// enabled.
  template <typename Parameters>
  void step_pieces(const ParameterPool<Parameters>& pool, const Batch& batch,
                   std::span<const TickLanes> lanes, ServoFeatures features);

  /// Runs the part of the tick that follows the servo step.
  void end_block(std::size_t block, const TickLanes& lanes);

  template <typename Parameters>
  void step_batch(const ParameterPool<Parameters>& pool, const Batch& batch);
  void step_batch(const Batch& batch);
  void step_blocks(std::size_t first, std::size_t last);
};

}  // namespace vdrive

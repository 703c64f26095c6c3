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

/// Block::effects of a block without effects.
inline constexpr std::uint32_t kNoEffects = 0xFFFF'FFFF;

/// Up to kLanes axes of one coupling, stepped side by side; see drive/block.hpp.
struct Block {
  BlockState state{};
  Coupling coupling = Coupling::rigid;
  std::uint32_t pool_index = 0;  // number among the blocks of this coupling
  std::uint32_t count = 0;
  std::uint32_t effects = kNoEffects;        // number among the blocks with effects
  bool has_play = false;                     // backlash in a lane
  std::array<std::uint32_t, kLanes> axes{};  // by lane, `count` of them
};

/// Blocks of one coupling that are stepped side by side, all with effects or all without.
struct Batch {
  Coupling coupling = Coupling::rigid;
  bool has_effects = false;
  std::size_t count = 0;  // up to kInterleavedBlocks
  std::array<std::size_t, kInterleavedBlocks> blocks{};
};

/// A tick that leaves every bit of a block as it was would do so again: it is left out until
/// something is written to an axis of the block.
struct Settled {
  std::uint64_t is_settled = 0;  // 0 or 1
  std::uint64_t ticks = 0;       // left out; they count as time on the target
};

/// Lanes of a block in a tick.
struct TickLanes {
  std::uint64_t steady = 0;  // SteadyBlock::lanes at the start of the tick
  std::uint64_t across = 0;  // the tick crosses a border between two segments
};

/// Where an axis is.
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

/// All that a bank is made of. Its parts stand in files of their own.
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
  std::vector<EffectBlock> effects;             // of the blocks that have any

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

  /// @return the axis for a change from outside: its next tick checks all of it.
  [[nodiscard]] Drive changed_drive(std::size_t axis) {
    ensure(axis < places.size(), "the axis is one of the bank's");
    end_steadiness(places[axis].block, std::uint64_t{1} << places[axis].lane);
    return drive(axis);
  }

  // bank_snapshot.cpp

  /// Shows each array of plain data that is state, in a fixed order, to `visit(first, count)`; what
  /// follows from the configuration is left out.
  template <typename Visit>
  void for_each_part(Visit visit);
  /// Whether no index leads outside of a pool, of the tables of modes and of homing methods, of the
  /// segments of a plan or of the lanes of a block; for state that comes from a file.
  [[nodiscard]] bool is_sound() const;

  // bank_blocks.cpp: axes become lanes of blocks

  void place_axes(Coupling coupling);
  void design_blocks();
  void add_effects();

  /// @return the effects of a block, or nullptr.
  [[nodiscard]] EffectBlock* effects_of(const Block& block) {
    return block.effects == kNoEffects ? nullptr : &effects[block.effects];
  }

  // bank_values.cpp: registers and what is stored of them

  /// @throws std::invalid_argument when an initial or a stored value is refused
  void start_axis(std::size_t axis);

  /// Configured values, then stored ones.
  /// @return the first initial value that was refused, or nullptr.
  const InitialValue* set_initial_values(std::size_t axis);
  void fill_memory(std::size_t axis);
  AbortCode write(std::size_t axis, ObjectRow row, std::int64_t value);

  // bank_tuning.cpp: what objects mean to the servo

  /// 3576h, 3577h: the load, the loops and the torques see the gear.
  void apply_gear(std::size_t axis);
  /// 6072h, 60E0h, 60E1h, 6075h, 6076h and the load torque, through the present gear.
  void apply_torques(std::size_t axis);
  /// What the effects of an axis are through `gear`; nothing where its block has none.
  void design_effects(std::size_t axis, const Gear& gear);

  // bank_step.cpp: a tick

  /// The next tick of a block is computed.
  void end_settled(std::size_t block);

  /// The next step goes through all of a tick for these lanes of a block.
  void end_steadiness(std::size_t block, std::uint64_t lanes);

  /// Gives the axes of a block that have noise the load torque of this tick.
  void draw_loads(const Block& block);

  /// What the effects of a block that has any do before the servo step.
  /// @param moved lanes whose frames may have moved
  void begin_effects(std::size_t block, std::uint64_t moved);

  /// Heats the motors of a block with effects.
  /// @return the lanes whose load level has changed: their tick is no steady one.
  std::uint64_t end_effects(std::size_t block);

  /// What the axes of a block do before the servo step.
  TickLanes begin_block(std::size_t block);

  /// Puts the segments that hold at `substep` into the lanes that cross a border.
  /// @return the sub-step up to which all of them hold.
  std::size_t cross_segments(const Batch& batch, std::size_t substep,
                             std::span<const TickLanes> lanes);

  /// The axes with an enabled touch probe look at their inputs, at the begin of the sub-step.
  template <typename Parameters>
  void look_at_probes(const ParameterPool<Parameters>& pool, const Batch& batch,
                      std::size_t substep);

  /// The servo step of a tick, in pieces where a lane crosses a border or a touch probe looks.
  template <typename Parameters>
  void step_pieces(const ParameterPool<Parameters>& pool, const Batch& batch,
                   std::span<const TickLanes> lanes, ServoFeatures features);

  /// What the axes of a block do after the servo step.
  void end_block(std::size_t block, const TickLanes& lanes);

  template <typename Parameters>
  void step_batch(const ParameterPool<Parameters>& pool, const Batch& batch);
  void step_batch(const Batch& batch);
  void step_blocks(std::size_t first, std::size_t last);
};

}  // namespace vdrive

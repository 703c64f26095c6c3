// SPDX-License-Identifier: Apache-2.0
#include "vdrive/axis_bank.hpp"

#include "drive/block.hpp"
#include "drive/demand.hpp"
#include "drive/objects.hpp"
#include "drive/power.hpp"
#include "drive/registers.hpp"
#include "drive/tick.hpp"
#include "plant/servo_block.hpp"
#include "plant/servo_design.hpp"
#include "torque_limit.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/plant/model_parameters.hpp"
#include "vdrive/status_digest.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace vdrive {
namespace {

using namespace vdrive::literals;

constexpr std::uint32_t kLongestSubstep_us = 125;  // the servo cycle: 8 kHz

TickTiming timing_of(std::chrono::microseconds period) {
  if (period < kShortestPeriod || period > kLongestPeriod) {
    throw std::invalid_argument("period = " + std::to_string(period.count()) +
                                " us must be 125 us to 10000 us");
  }
  const auto period_us = static_cast<std::uint32_t>(period.count());
  const std::uint32_t substeps = (period_us + kLongestSubstep_us - 1U) / kLongestSubstep_us;
  return {.period_us = period_us,
          .substeps = substeps,
          .substep = static_cast<double>(period_us) * 1.0e-6 / static_cast<double>(substeps)};
}

/// Bit for bit: a set of parameters is shared, and a tick left out, only where nothing at all would
/// change.
template <typename Numbers>
bool alike(const Numbers& a, const Numbers& b) {
  using Words = std::array<std::uint64_t, sizeof(Numbers) / sizeof(std::uint64_t)>;
  return std::bit_cast<Words>(a) == std::bit_cast<Words>(b);
}

/// Parameters of the blocks of one kind. Most axes of a bank are alike: equal blocks share one set
/// until one of their axes changes, which keeps the sets in the nearest cache.
template <typename Parameters>
struct ParameterPool {
  std::vector<Parameters> sets;       // initial sets, then one place for each block of this kind
  std::vector<std::uint32_t> in_use;  // by block of this kind
  std::vector<std::uint32_t> own;     // by block of this kind

  void add_block(const Parameters& initial) {
    const auto same = std::ranges::find_if(sets, [&initial](const Parameters& set) {
      return alike(set, initial);
    });
    in_use.push_back(static_cast<std::uint32_t>(same - sets.begin()));
    if (same == sets.end()) sets.push_back(initial);
  }

  void finish() {
    own.resize(in_use.size());
    for (std::uint32_t& place : own) {
      place = static_cast<std::uint32_t>(sets.size());
      sets.emplace_back();
    }
  }

  [[nodiscard]] const Parameters& get(std::size_t block) const {
    ensure(block < in_use.size() && in_use[block] < sets.size(), "a block has its parameters");
    return sets[in_use[block]];
  }

  [[nodiscard]] Parameters& change(std::size_t block) {
    if (in_use[block] != own[block]) {
      sets[own[block]] = sets[in_use[block]];
      in_use[block] = own[block];
    }
    return sets[own[block]];
  }
};

struct Block {
  BlockState state{};
  Coupling coupling = Coupling::rigid;
  std::uint32_t pool_index = 0;
  std::uint32_t count = 0;
  bool has_play = false;
  std::array<std::uint32_t, kLanes> axes{};
};

/// Blocks of one coupling that are stepped side by side.
struct Batch {
  Coupling coupling = Coupling::rigid;
  std::size_t count = 0;  // up to kInterleavedBlocks
  std::array<std::size_t, kInterleavedBlocks> blocks{};
};

std::uint64_t all_lanes(const Block& block) {
  return (std::uint64_t{1} << block.count) - 1U;
}

/// @return whether all axes of the block stand on their targets or have no power.
bool rests(const Block& block) {
  const SteadyBlock& steady = block.state.steady;
  return (steady.standing | steady.unpowered) == all_lanes(block);
}

/// @return whether a tick may leave `servo` as it is.
bool may_stand_still(const ServoState& servo) {
  return std::ranges::all_of(servo.velocity, [](double velocity) {
    return velocity == 0.0;
  });
}

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

template <typename Visit>
void for_each_lane(std::uint64_t lanes, Visit visit) {
  for (; lanes != 0; lanes &= lanes - 1U) visit(static_cast<std::size_t>(std::countr_zero(lanes)));
}

struct Place {
  std::uint32_t block = 0;
  std::uint32_t lane = 0;
};

/// What 1010h stored of an axis. Not every object need be there: an earlier program may have stored
/// it, whose dictionary had fewer.
struct ParameterMemory {
  std::uint64_t present = 0;  // bit n: values[n] is of row kStoredRows[n]
  std::array<std::int64_t, kStoredCount> values{};
};

static_assert(kStoredCount <= 64);
static_assert(std::is_trivially_copyable_v<ParameterMemory>);
static_assert(std::is_trivially_copyable_v<BlockState>);
static_assert(std::is_trivially_copyable_v<Settled>);
static_assert(std::is_trivially_copyable_v<DriveState>);
static_assert(std::is_trivially_copyable_v<DriveRegisters>);
static_assert(std::is_trivially_copyable_v<AxisStatus>);

}  // namespace

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

  /// Shows each array of plain data that is state, in a fixed order, to `visit(first, count)`; what
  /// follows from the configuration is left out.
  template <typename Visit>
  void for_each_part(Visit visit);
  [[nodiscard]] bool is_sound() const;

  void place_axes(Coupling coupling);
  void design_blocks();
  void start_axis(std::size_t axis);

  /// Configured values, then stored ones.
  /// @return the first initial value that was refused, or nullptr.
  const InitialValue* set_initial_values(std::size_t axis);
  void set_stored_values(std::size_t axis);
  AbortCode keep(std::size_t axis, ObjectAddress object, std::int64_t value);
  void fill_memory(std::size_t axis);
  AbortCode write(std::size_t axis, ObjectRow row, std::int64_t value);
  void apply_gear(std::size_t axis);
  void apply_torques(std::size_t axis);

  /// The next tick of a block is computed.
  void end_settled(std::size_t block);

  /// The next step goes through all of a tick for these lanes of a block.
  void end_steadiness(std::size_t block, std::uint64_t lanes);

  /// What the axes of a block do before the servo step.
  TickLanes begin_block(std::size_t block);

  /// Puts the segments that hold at `substep` into the lanes that cross a border.
  /// @return the sub-step up to which all of them hold.
  std::size_t cross_segments(const Batch& batch, std::size_t substep,
                             std::span<const TickLanes> lanes);

  /// What the axes of a block do after the servo step.
  void end_block(std::size_t block, const TickLanes& lanes);

  template <typename Parameters>
  void step_batch(const ParameterPool<Parameters>& pool, const Batch& batch);
  void step_batch(const Batch& batch);
  void step_blocks(std::size_t first, std::size_t last);
};

namespace {

[[noreturn]] void refuse(std::size_t axis, const char* kind, const InitialValue& refused) {
  throw std::invalid_argument("axis " + std::to_string(axis) + ": " + kind + " value " +
                              std::to_string(refused.value) + " of " +
                              object_text(refused.address) + " is refused");
}

Gear gear_of(const DriveRegisters& registers) {
  return {static_cast<std::uint32_t>(registers.values["gear_ratio_numerator"_object]),
          static_cast<std::uint32_t>(registers.values["gear_ratio_denominator"_object])};
}

/// 60E0h or 60E1h with 6072h [N.m].
double torque_limit_of(const DriveRegisters& registers, const AxisModel& model,
                       ObjectRow relative) {
  const auto value = [&registers](ObjectRow row) {
    return static_cast<double>(registers.values[row]);
  };
  const double rated_torque = value("motor_rated_torque"_object) * 1.0e-3;
  const double current_torque =
      value("motor_rated_current"_object) * 1.0e-3 * model.torque_constant;
  const double highest = value("max_torque"_object) * 1.0e-3 * rated_torque;
  return torque_limit(highest, value(relative) * 1.0e-3, std::min(rated_torque, current_torque));
}

}  // namespace

void AxisBank::State::place_axes(Coupling coupling) {
  std::uint32_t pool_index = 0;
  for (std::uint32_t axis = 0; axis < configurations.size(); ++axis) {
    if (configurations[axis].model.coupling != coupling) continue;
    if (pool_index == 0 || blocks.back().count == kLanes) {
      blocks.push_back({.coupling = coupling, .pool_index = pool_index});
      ++pool_index;
    }
    Block& block = blocks.back();
    places[axis] = {static_cast<std::uint32_t>(blocks.size() - 1), block.count};
    block.axes[block.count] = axis;
    ++block.count;
  }
}

void AxisBank::State::design_blocks() {
  for (Block& block : blocks) {
    ensure(block.count > 0, "a block has an axis");
    RigidParameters rigid_set{};
    ElasticParameters elastic_set{};
    block.state.servo.powered.fill(1.0);
    block.state.servo.closes_position.fill(1.0);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      // Lanes without an axis compute a copy of the first one, which stands still at 0.
      const std::uint32_t axis = block.axes[lane < block.count ? lane : 0];
      const AxisModel& model = configurations[axis].model;
      if (block.coupling == Coupling::rigid) {
        design_lane(model, {}, timing.substep, lane, rigid_set);
      } else {
        design_lane(model, {}, timing.substep, lane, elastic_set);
      }
    }
    if (block.coupling == Coupling::rigid) {
      rigid.add_block(rigid_set);
    } else {
      block.has_play = std::ranges::any_of(elastic_set.half_backlash, [](double play) {
        return play != 0.0;
      });
      elastic.add_block(elastic_set);
    }
  }
  rigid.finish();
  elastic.finish();
}

void AxisBank::State::start_axis(std::size_t axis) {
  Drive drive = this->drive(axis);
  const auto position = static_cast<double>(configurations[axis].initial_position);
  ServoState& servo = drive.servo();
  for (Lane* lane : {&servo.position, &servo.measured, &servo.motor_reading, &servo.load_position,
                     &servo.load_reading}) {
    (*lane)[drive.lane()] = position;
  }
  drive.registers().settings = configurations[axis].settings;
  drive.registers().single_encoder =
      configurations[axis].model.feedback == Feedback::single_encoder;
  fill_memory(axis);
  power_up(drive, true);
  if (const InitialValue* const refused = set_initial_values(axis)) {
    refuse(axis, "initial", *refused);
  }
  show(drive);
}

void AxisBank::State::fill_memory(std::size_t axis) {
  for (const InitialValue& stored : configurations[axis].stored) {
    if (keep(axis, stored.address, stored.value) != AbortCode::none) refuse(axis, "stored", stored);
  }
  drive(axis).registers().memory_error = configurations[axis].memory_error;
}

AbortCode AxisBank::State::keep(std::size_t axis, ObjectAddress object, std::int64_t value) {
  const AbortCode code = check_stored(object, value);
  if (code == AbortCode::none) {
    ensure(axis < memories.size(), "the axis is one of the bank's");
    const auto* const place = std::ranges::lower_bound(kStoredRows, *find_object(object));
    const auto position = static_cast<std::size_t>(place - kStoredRows.begin());
    memories[axis].values[position] = value;
    memories[axis].present |= std::uint64_t{1} << position;
  }
  return code;
}

void AxisBank::State::set_stored_values(std::size_t axis) {
  const ParameterMemory& memory = memories[axis];
  Drive drive = this->drive(axis);
  for (std::size_t position = 0; position < kStoredCount; ++position) {
    if ((memory.present >> position & 1U) != 0) {
      static_cast<void>(write_object(drive, kStoredRows[position], memory.values[position]));
    }
  }
}

const InitialValue* AxisBank::State::set_initial_values(std::size_t axis) {
  Drive drive = this->drive(axis);
  drive.registers().values["serial_number"_object] = configurations[axis].serial_number;
  const InitialValue* refused = nullptr;
  for (const InitialValue& initial : configurations[axis].parameters) {
    const auto row = find_object(initial.address);
    // A controlword is a command, not a parameter: no axis is enabled by its configuration.
    const bool allowed = row && *row != "ds402_controlword"_object &&
                         write_object(drive, *row, initial.value) == AbortCode::none;
    if (!allowed && refused == nullptr) refused = &initial;
  }
  set_stored_values(axis);
  update_derived(drive);
  apply_gear(axis);
  return refused;
}

AbortCode AxisBank::State::write(std::size_t axis, ObjectRow row, std::int64_t value) {
  Drive drive = changed_drive(axis);
  if (const AbortCode code = write_object(drive, row, value); code != AbortCode::none) return code;
  const Change change = describe(row).change;
  if (change == Change::gear) {
    apply_gear(axis);
  } else if (change == Change::torque_limits) {
    apply_torques(axis);
  }
  return AbortCode::none;
}

void AxisBank::State::apply_gear(std::size_t axis) {
  Drive drive = this->drive(axis);
  const AxisModel& model = configurations[axis].model;
  const Gear gear = gear_of(drive.registers());
  const double ratio = static_cast<double>(gear.numerator) / static_cast<double>(gear.denominator);
  DriveRegisters& registers = drive.registers();
  if (ratio != registers.gear_ratio) {
    // The load stays where it is when the gear is set.
    ServoState& servo = drive.servo();
    servo.load_offset[drive.lane()] +=
        (registers.gear_ratio - ratio) * servo.position[drive.lane()];
    registers.gear_ratio = ratio;
    const Block& block = blocks[places[axis].block];
    if (block.coupling == Coupling::rigid) {
      design_lane(model, gear, timing.substep, drive.lane(), rigid.change(block.pool_index));
    } else {
      design_lane(model, gear, timing.substep, drive.lane(), elastic.change(block.pool_index));
    }
  }
  apply_torques(axis);
}

void AxisBank::State::apply_torques(std::size_t axis) {
  Drive drive = this->drive(axis);
  const DriveRegisters& registers = drive.registers();
  const AxisModel& model = configurations[axis].model;
  const Gear gear = gear_of(registers);
  const double unit = torque_unit(model, gear);
  const auto value = [&registers](ObjectRow row) {
    return static_cast<double>(registers.values[row]);
  };
  UnitBlock& units = drive.block().units;
  units.torque_per_mille[drive.lane()] = unit / (value("motor_rated_torque"_object) * 1.0e-6);
  units.current_per_mille[drive.lane()] =
      unit / model.torque_constant / (value("motor_rated_current"_object) * 1.0e-6);
  drive.servo().load_torque[drive.lane()] =
      value("test_load_torque"_object) * 1.0e-3 * load_torque_factor(model, gear);
  const TorqueLimits limits{
      .positive = torque_limit_of(registers, model, "positive_torque_limit_relative"_object),
      .negative = torque_limit_of(registers, model, "negative_torque_limit_relative"_object)};
  const Block& block = blocks[places[axis].block];
  LoopParameters wanted = block.coupling == Coupling::rigid ? rigid.get(block.pool_index).loop
                                                            : elastic.get(block.pool_index).loop;
  const double upper = wanted.upper_limit[drive.lane()];
  const double lower = wanted.lower_limit[drive.lane()];
  limit_lane(limits, unit, drive.lane(), wanted);
  if (wanted.upper_limit[drive.lane()] == upper && wanted.lower_limit[drive.lane()] == lower) {
    return;
  }
  if (block.coupling == Coupling::rigid) {
    rigid.change(block.pool_index).loop = wanted;
  } else {
    elastic.change(block.pool_index).loop = wanted;
  }
}

void AxisBank::State::end_settled(std::size_t block) {
  BlockState& state = blocks[block].state;
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

TickLanes AxisBank::State::begin_block(std::size_t block_index) {
  Block& block = blocks[block_index];
  ensure(block.count > 0, "a block has an axis");
  const DemandBlock& demand = block.state.demand;
  const std::uint64_t all = all_lanes(block);
  TickLanes lanes{.steady = block.state.steady.lanes & ~lanes_out_of_frame(demand) & all};
  end_steadiness(block_index, block.state.steady.lanes & ~lanes.steady);
  for_each_lane(all & ~lanes.steady, [this, block_index](std::size_t lane) {
    Drive drive = this->drive(block_index, lane);
    begin_tick(drive);
  });
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

void AxisBank::State::end_block(std::size_t block_index, const TickLanes& lanes) {
  Block& block = blocks[block_index];
  const std::uint64_t unpowered = lanes.steady & block.state.steady.unpowered;
  const std::uint64_t holding = lanes.steady & ~unpowered;
  if (unpowered != 0) rest_at_load(block.state.demand, block.state.servo, unpowered);
  const std::uint64_t steady =
      unpowered | (holding != 0 ? end_steady_tick(block.state, holding, timing) : 0U);
  end_steadiness(block_index, lanes.steady & ~steady);
  const std::uint64_t others = all_lanes(block) & ~steady;
  for_each_lane(others, [this, block_index](std::size_t lane) {
    Drive drive = this->drive(block_index, lane);
    watch_tick(drive);
  });
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): filled by the next statement
  NumberBlock numbers;
  round_numbers(block.state, numbers);
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
  std::array<ServoBlock<Parameters>, kInterleavedBlocks> servo_blocks{};
  std::array<TickLanes, kInterleavedBlocks> lanes{};
  ServoFeatures features;
  std::uint64_t across = 0;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): filled where it is read
  std::array<ServoState, kInterleavedBlocks> before;
  std::array<bool, kInterleavedBlocks> may_settle{};
  for (std::size_t i = 0; i < batch.count; ++i) {
    Block& block = blocks[batch.blocks[i]];
    may_settle[i] = rests(block) && may_stand_still(block.state.servo);
    if (may_settle[i]) before[i] = block.state.servo;
    lanes[i] = begin_block(batch.blocks[i]);
    across |= lanes[i].across;
    features.general = features.general || !is_plain(block.state.servo);
    features.play = features.play || block.has_play;
    servo_blocks[i] = {&pool.get(block.pool_index), &block.state.demand, &block.state.servo};
  }
  const std::span<const ServoBlock<Parameters>> work(servo_blocks.data(), batch.count);
  for (std::size_t first = 0; first < timing.substeps;) {
    const std::size_t last = across == 0 ? timing.substeps : cross_segments(batch, first, lanes);
    step_servo(work, {first, last, static_cast<double>(timing.substeps), timing.substep}, features);
    first = last;
  }
  for (std::size_t i = 0; i < batch.count; ++i) {
    Block& block = blocks[batch.blocks[i]];
    end_block(batch.blocks[i], lanes[i]);
    const bool is_settled = may_settle[i] && alike(before[i], block.state.servo);
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
    if (batch.count == kInterleavedBlocks || batch.coupling != coupling) {
      step_batch(batch);
      batch = {.coupling = coupling};
    }
    batch.blocks[batch.count] = first;
    ++batch.count;
  }
  step_batch(batch);
}

template <typename Visit>
void AxisBank::State::for_each_part(Visit visit) {
  for (Block& block : blocks) visit(&block.state, 1);
  visit(settled.data(), settled.size());
  visit(rigid.sets.data(), rigid.sets.size());
  visit(rigid.in_use.data(), rigid.in_use.size());
  visit(elastic.sets.data(), elastic.sets.size());
  visit(elastic.in_use.data(), elastic.in_use.size());
  visit(drive_states.data(), drive_states.size());
  visit(drive_registers.data(), drive_registers.size());
  visit(statuses.data(), statuses.size());
  visit(memories.data(), memories.size());
}

/// Whether no index leads outside of a pool or of the table of modes; for state that comes from a
/// file.
bool AxisBank::State::is_sound() const {
  const auto inside = [](const auto& pool) {
    return std::ranges::all_of(pool.in_use, [&pool](std::uint32_t set) {
      return set < pool.sets.size();
    });
  };
  const bool has_modes = std::ranges::all_of(drive_states, [](const DriveState& drive) {
    return is_operating_mode(static_cast<std::int64_t>(drive.mode.actual)) &&
           is_operating_mode(static_cast<std::int64_t>(drive.mode.wanted));
  });
  return inside(rigid) && inside(elastic) && has_modes;
}

AxisBank::AxisBank(std::span<const AxisConfiguration> axes, std::chrono::microseconds period)
    : state_(std::make_unique<State>()) {
  if (axes.empty()) throw std::invalid_argument("a bank needs at least one axis");
  State& state = *state_;
  state.timing = timing_of(period);
  state.configurations.assign(axes.begin(), axes.end());
  for (const AxisConfiguration& axis : axes) validate(axis.model);
  state.places.resize(axes.size());
  state.statuses.resize(axes.size());
  state.memories.resize(axes.size());
  state.place_axes(Coupling::rigid);
  state.place_axes(Coupling::two_inertia);
  state.settled.resize(state.blocks.size());
  state.drive_states.resize(state.blocks.size() * kLanes);
  state.drive_registers.resize(state.blocks.size() * kLanes);
  state.design_blocks();
  for (std::size_t axis = 0; axis < axes.size(); ++axis) state.start_axis(axis);
}

AxisBank::~AxisBank() = default;

AxisBank::AxisBank(const AxisBank& other) : state_(std::make_unique<State>(*other.state_)) {}

AxisBank& AxisBank::operator=(const AxisBank& other) {
  if (this != &other) *state_ = *other.state_;
  return *this;
}

AxisBank::AxisBank(AxisBank&&) noexcept = default;
AxisBank& AxisBank::operator=(AxisBank&&) noexcept = default;

std::size_t AxisBank::size() const noexcept {
  return state_->places.size();
}

std::chrono::microseconds AxisBank::period() const noexcept {
  return std::chrono::microseconds{state_->timing.period_us};
}

AbortCode AxisBank::write(std::size_t axis, ObjectAddress object, std::int64_t value) noexcept {
  const auto row = find_object(object);
  return row ? write(axis, *row, value) : check_address(object);
}

AbortCode AxisBank::write(std::size_t axis, ObjectRow row, std::int64_t value) noexcept {
  return state_->write(axis, row, value);
}

ReadResult AxisBank::read(std::size_t axis, ObjectAddress object) const noexcept {
  const auto row = find_object(object);
  return row ? read(axis, *row) : ReadResult{check_address(object), 0};
}

ReadResult AxisBank::read(std::size_t axis, ObjectRow row) const noexcept {
  ReadResult result;
  result.value = read_object(state_->drive(axis), row, result.code);
  return result;
}

void AxisBank::step() noexcept {
  step_groups(0, group_count());
}

std::size_t AxisBank::group_count() const noexcept {
  return state_->blocks.size();
}

void AxisBank::step_groups(std::size_t first, std::size_t last) noexcept {
  ensure(first <= last && last <= state_->blocks.size(), "the groups are the bank's");
  state_->step_blocks(first, last);
}

const AxisStatus& AxisBank::status(std::size_t axis) const noexcept {
  ensure(axis < size(), "the axis is one of the bank's");
  return state_->statuses[axis];
}

std::span<const AxisStatus> AxisBank::statuses() const noexcept {
  return state_->statuses;
}

PowerState AxisBank::power_state(std::size_t axis) const noexcept {
  return state_->drive(axis).state().power.machine.state();
}

std::uint32_t AxisBank::ignored_set_points(std::size_t axis) const noexcept {
  return state_->drive(axis).state().ignored_set_points;
}

// NOLINTNEXTLINE(bugprone-exception-escape): the matrices have fixed sizes, nothing allocates
void AxisBank::power_cycle(std::size_t axis) noexcept {
  Drive drive = state_->changed_drive(axis);
  power_up(drive, false);
  static_cast<void>(state_->set_initial_values(axis));
  show(drive);
}

AbortCode AxisBank::check_stored(ObjectAddress object, std::int64_t value) noexcept {
  const auto row = find_object(object);
  if (!row) return check_address(object);
  return describe(*row).storage == Storage::flash ? check_object_value(*row, value)
                                                  : AbortCode::cannot_store_or_transfer;
}

void AxisBank::read_parameters(std::size_t axis,
                               std::span<std::int64_t, kStoredCount> values) const noexcept {
  Drive drive = state_->drive(axis);
  for (std::size_t position = 0; position < kStoredCount; ++position) {
    values[position] = drive.registers().values[kStoredRows[position]];
  }
}

AbortCode AxisBank::set_stored(std::size_t axis, ObjectAddress object,
                               std::int64_t value) noexcept {
  return state_->keep(axis, object, value);
}

void AxisBank::forget_stored(std::size_t axis) noexcept {
  state_->memories[axis] = {};
  state_->drive(axis).registers().memory_error = false;
}

void AxisBank::report_connection_loss(std::size_t axis) noexcept {
  Drive drive = state_->changed_drive(axis);
  lose_connection(drive);
}

AxisBank::Snapshot AxisBank::snapshot() const {
  return Snapshot(std::make_unique<State>(*state_));
}

void AxisBank::restore(const Snapshot& snapshot, Memory memory) {
  const State& saved = *snapshot.state_;
  if (saved.places.size() != size() || saved.timing.period_us != state_->timing.period_us) {
    throw std::invalid_argument("snapshot of " + std::to_string(saved.places.size()) +
                                " axes does not fit a bank of " + std::to_string(size()));
  }
  if (memory == Memory::of_snapshot) {
    *state_ = saved;
    return;
  }
  State next = saved;
  next.memories.swap(state_->memories);
  for (std::size_t axis = 0; axis < size(); ++axis) {
    next.drive(axis).registers().memory_error = state_->drive(axis).registers().memory_error;
  }
  *state_ = std::move(next);
}

void AxisBank::save(Snapshot& snapshot) const {
  *snapshot.state_ = *state_;
}

std::uint64_t AxisBank::snapshot_layout() noexcept {
  // Counted up by hand when a member changes its meaning while every size stays as it is.
  constexpr std::uint64_t kVersion = 4;
  constexpr std::uint64_t kPrime = 1099511628211ULL;  // FNV-1a over words
  std::uint64_t layout = 14695981039346656037ULL;
  for (const std::uint64_t part :
       {kVersion, std::uint64_t{kObjectCount}, std::uint64_t{kLanes},
        std::uint64_t{sizeof(BlockState)}, std::uint64_t{sizeof(Settled)},
        std::uint64_t{sizeof(RigidParameters)}, std::uint64_t{sizeof(ElasticParameters)},
        std::uint64_t{sizeof(DriveState)}, std::uint64_t{sizeof(DriveRegisters)},
        std::uint64_t{sizeof(AxisStatus)}, std::uint64_t{sizeof(ParameterMemory)},
        std::uint64_t{std::endian::native == std::endian::little}}) {
    layout = (layout ^ part) * kPrime;
  }
  for (std::size_t row = 0; row < kObjectCount; ++row) {  // registers are kept by row
    const ObjectAddress address = describe(static_cast<ObjectRow>(row)).address;
    layout = (layout ^ (address.index * 256U + address.subindex)) * kPrime;
  }
  return layout;
}

AxisBank::Snapshot AxisBank::snapshot_from(std::span<const std::byte> bytes) const {
  Snapshot snapshot = this->snapshot();
  std::size_t used = 0;
  snapshot.state_->for_each_part([&](auto* first, std::size_t count) {
    const std::size_t size = sizeof(*first) * count;
    if (size != 0 && size <= bytes.size() - used) {
      std::memcpy(first, bytes.data() + used, size);
      used += size;
    } else if (size != 0) {
      throw std::invalid_argument("a snapshot of " + std::to_string(bytes.size()) +
                                  " bytes is too short for this bank");
    }
  });
  if (used != bytes.size() || !snapshot.state_->is_sound()) {
    throw std::invalid_argument("a snapshot of " + std::to_string(bytes.size()) +
                                " bytes does not fit this bank");
  }
  return snapshot;
}

std::uint64_t AxisBank::status_hash() const noexcept {
  return digest_of(state_->statuses, state_->statuses.size(), {}).image;
}

AxisBank::Snapshot::Snapshot(std::unique_ptr<State> state) : state_(std::move(state)) {}

AxisBank::Snapshot::~Snapshot() = default;

std::vector<std::byte> AxisBank::Snapshot::bytes() const {
  std::vector<std::byte> bytes;
  state_->for_each_part([&bytes](const auto* first, std::size_t count) {
    const auto part = std::as_bytes(std::span(first, count));
    bytes.insert(bytes.end(), part.begin(), part.end());
  });
  return bytes;
}

AxisBank::Snapshot::Snapshot(const Snapshot& other)
    : state_(std::make_unique<State>(*other.state_)) {}

AxisBank::Snapshot& AxisBank::Snapshot::operator=(const Snapshot& other) {
  if (this != &other) *state_ = *other.state_;
  return *this;
}

AxisBank::Snapshot::Snapshot(Snapshot&&) noexcept = default;
AxisBank::Snapshot& AxisBank::Snapshot::operator=(Snapshot&&) noexcept = default;

}  // namespace vdrive

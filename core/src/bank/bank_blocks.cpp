// SPDX-License-Identifier: Apache-2.0
#include "bank/bank_state.hpp"
#include "plant/servo_design.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <span>

namespace vdrive {

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
  add_effects();
}

void AxisBank::State::add_effects() {
  for (Block& block : blocks) {
    const std::span axes_of_block(block.axes.data(), block.count);
    const bool has_any = std::ranges::any_of(axes_of_block, [this](std::uint32_t axis) {
      return has_effects(configurations[axis].model);
    });
    if (!has_any) continue;
    block.effects = static_cast<std::uint32_t>(effects.size());
    effects.push_back(no_effects());
    for (std::uint32_t lane = 0; lane < block.count; ++lane) {
      const std::uint32_t axis = block.axes[lane];
      design_effects(axis, {});
      start_effects(configurations[axis].model, axis, lane, effects.back());
    }
  }
}

}  // namespace vdrive

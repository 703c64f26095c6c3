// SPDX-License-Identifier: Apache-2.0
#include "bank/bank_state.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/cia402/homing_method.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

namespace vdrive {

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
  visit(noises.data(), noises.size());
  visit(effects.data(), effects.size());
}

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
  const bool has_methods = std::ranges::all_of(drive_states, [](const DriveState& drive) {
    const HomingState& homing = drive.modes.homing;
    const bool runs = homing.stage != HomingStage::idle && homing.stage != HomingStage::failed;
    return !runs || find_homing_method(homing.method) != nullptr;
  });
  const bool has_segments =
      std::ranges::all_of(drive_registers, [](const DriveRegisters& registers) {
        return registers.profile.segment_count() <= Profile::kMaximumSegments &&
               registers.jerk_profile.segment_count() <= JerkProfile::kMaximumSegments;
      });
  const bool has_lanes = std::ranges::all_of(blocks, [this](const Block& block) {
    const SteadyBlock& steady = block.state.steady;
    const std::uint64_t lanes = steady.lanes | steady.standing | steady.unpowered |
                                block.state.noisy | block.state.modulo | block.state.probed |
                                block.state.jerk_limited | block.state.frozen;
    const std::uint64_t hot = block.effects == kNoEffects ? 0U : effects[block.effects].state.hot;
    return (lanes | hot) >> block.count == 0;
  });
  return inside(rigid) && inside(elastic) && has_modes && has_methods && has_segments && has_lanes;
}

AxisBank::Snapshot AxisBank::snapshot() const {
  return Snapshot(std::make_unique<State>(*state_));
}

void AxisBank::restore(const Snapshot& snapshot, Memory memory) {
  const State& saved = *snapshot.state_;
  if (saved.places.size() != size() || saved.timing.period_us != state_->timing.period_us) {
    throw std::invalid_argument("the snapshot has " + std::to_string(saved.places.size()) +
                                " axes and a period of " + std::to_string(saved.timing.period_us) +
                                " us, but the bank has " + std::to_string(size()) + " axes and " +
                                std::to_string(state_->timing.period_us) + " us");
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
  *state_ = next;  // copied, not moved: the arrays keep their addresses
}

void AxisBank::save(Snapshot& snapshot) const {
  *snapshot.state_ = *state_;
}

std::size_t AxisBank::snapshot_size() const noexcept {
  std::size_t size = 0;
  state_->for_each_part([&size](const auto* first, std::size_t count) {
    size += sizeof(*first) * count;
  });
  return size;
}

void AxisBank::save(std::span<std::byte> bytes) const noexcept {
  std::size_t used = 0;
  state_->for_each_part([&](const auto* first, std::size_t count) {
    const auto part = std::as_bytes(std::span(first, count));
    ensure(part.size() <= bytes.size() - used, "the bytes have the size of a snapshot");
    std::ranges::copy(part, bytes.begin() + static_cast<std::ptrdiff_t>(used));
    used += part.size();
  });
}

std::uint64_t AxisBank::snapshot_layout() noexcept {
  // Increment by hand when a member changes its meaning but every size stays the same.
  constexpr std::uint64_t kVersion = 4;
  constexpr std::uint64_t kPrime = 1099511628211ULL;  // FNV-1a over words
  std::uint64_t layout = 14695981039346656037ULL;
  for (const std::uint64_t part :
       {kVersion, std::uint64_t{kObjectCount}, std::uint64_t{kLanes},
        std::uint64_t{sizeof(BlockState)}, std::uint64_t{sizeof(Settled)},
        std::uint64_t{sizeof(RigidParameters)}, std::uint64_t{sizeof(ElasticParameters)},
        std::uint64_t{sizeof(DriveState)}, std::uint64_t{sizeof(DriveRegisters)},
        std::uint64_t{sizeof(AxisStatus)}, std::uint64_t{sizeof(ParameterMemory)},
        std::uint64_t{sizeof(LoadNoise)}, std::uint64_t{sizeof(EffectBlock)},
        std::uint64_t{std::endian::native == std::endian::little}}) {
    layout = (layout ^ part) * kPrime;
  }
  for (const ObjectDescription& row : kObjectRows) {  // registers are stored by row
    layout = (layout ^ (row.address.index * 256U + row.address.subindex)) * kPrime;
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

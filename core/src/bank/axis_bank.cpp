// SPDX-License-Identifier: Apache-2.0
#include "vdrive/axis_bank.hpp"

#include "bank/bank_state.hpp"
#include "drive/objects.hpp"
#include "drive/power.hpp"
#include "drive/tick.hpp"
#include "scramble.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/plant/model_parameters.hpp"
#include "vdrive/status_digest.hpp"

#include <memory>
#include <span>
#include <stdexcept>
#include <string>

namespace vdrive {

namespace {

constexpr std::uint32_t kLongestSubstep_us = 125;  // the servo cycle: 8 kHz

TickTiming timing_of(std::chrono::microseconds period) {
  if (period < kShortestPeriod || period > kLongestPeriod) {
    throw std::invalid_argument("period = " + std::to_string(period.count()) +
                                " us is out of range: must be from 125 to 10000 us");
  }
  const auto period_us = static_cast<std::uint32_t>(period.count());
  const std::uint32_t substeps = (period_us + kLongestSubstep_us - 1U) / kLongestSubstep_us;
  return {.period_us = period_us,
          .substeps = substeps,
          .substep = static_cast<double>(period_us) * 1.0e-6 / static_cast<double>(substeps)};
}

}  // namespace

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
  state.noises.resize(axes.size());
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
  const auto row = find_row(object);
  return row ? write(axis, *row, value) : check_address(object);
}

AbortCode AxisBank::write(std::size_t axis, ObjectRow row, std::int64_t value) noexcept {
  return state_->write(axis, row, value);
}

AbortCode AxisBank::check(std::size_t axis, ObjectRow row, std::int64_t value) const noexcept {
  return check_object(state_->drive(axis), row, value);
}

ReadResult AxisBank::read(std::size_t axis, ObjectAddress object) const noexcept {
  const auto row = find_row(object);
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

std::size_t AxisBank::group_of(std::size_t axis) const noexcept {
  ensure(axis < size(), "the axis is one of the bank's");
  return state_->places[axis].block;
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

void AxisBank::set_load_noise(std::size_t axis, double rms, std::uint64_t seed) noexcept {
  Drive drive = state_->changed_drive(axis);
  LoadNoise& noise = state_->noises[axis];
  ensure(rms >= 0.0 && rms <= kLargestLoadNoise, "the noise of a load is within its limits");
  noise.stream = scramble(scramble(seed) + axis);
  noise.ticks = 0;
  noise.rms = rms;
  const std::uint64_t lane = std::uint64_t{1} << drive.lane();
  std::uint64_t& noisy = drive.block().noisy;
  noisy = rms > 0.0 ? noisy | lane : noisy & ~lane;
  state_->apply_torques(axis);
}

AbortCode AxisBank::check_stored(ObjectAddress object, std::int64_t value) noexcept {
  return vdrive::check_stored(object, value);
}

void AxisBank::read_parameters(std::size_t axis, std::span<std::int64_t> values) const noexcept {
  ensure(values.size() == kStoredCount, "each stored object has its value");
  Drive drive = state_->drive(axis);
  for (std::size_t position = 0; position < kStoredCount; ++position) {
    values[position] = drive.registers().values[kStoredRows[position]];
  }
}

AbortCode AxisBank::set_stored(std::size_t axis, ObjectAddress object,
                               std::int64_t value) noexcept {
  ensure(axis < size(), "the axis is one of the bank's");
  return state_->memories[axis].keep(object, value);
}

void AxisBank::forget_stored(std::size_t axis) noexcept {
  ensure(axis < size(), "the axis is one of the bank's");
  state_->memories[axis] = {};
  state_->drive(axis).registers().memory_error = false;
}

void AxisBank::report_connection_loss(std::size_t axis) noexcept {
  Drive drive = state_->changed_drive(axis);
  lose_connection(drive);
}

std::uint64_t AxisBank::status_hash() const noexcept {
  return digest_of(state_->statuses, state_->statuses.size(), {}).image;
}

}  // namespace vdrive

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_configuration.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace vdrive {

/// Answer to a read: `value` holds when `code` is AbortCode::none, else it is 0.
struct ReadResult {
  AbortCode code = AbortCode::none;
  std::int64_t value = 0;
};

/// Shortest and longest tick.
inline constexpr std::chrono::microseconds kShortestPeriod{125};
inline constexpr std::chrono::microseconds kLongestPeriod{10'000};

/// Limit of the noise of a load torque [N.m].
inline constexpr double kLargestLoadNoise = 1.0e4;

/// Many CiA 402 axes in the operating modes of 6502h, stepped together.
///
/// A step is a function: it takes the writes since the last step and gives each axis' status image.
/// No clock, thread, lock, allocation or exception in `write`, `read` and `step`. The same writes
/// give the same bits whatever the vector width, the partition of `step_groups`, or the build.
///
/// Between two steps `write` acts in the order of the calls: the power state machine and the
/// set-point handshake run once for every controlword, so several words in one tick do what they
/// would do in several. Written objects read back at once; computed objects show the last tick.
class AxisBank {
 public:
  /// Powers every axis up: transitions 0 and 1 are done, the status images are valid.
  /// @throws std::invalid_argument when `axes` is empty, the period is outside 125 µs to 10 ms, a
  ///         model parameter is outside its range (naming parameter, value, unit and limit), or an
  ///         initial or stored value is refused by the dictionary.
  AxisBank(std::span<const AxisConfiguration> axes, std::chrono::microseconds period);
  ~AxisBank();
  AxisBank(const AxisBank& other);
  AxisBank& operator=(const AxisBank& other);
  AxisBank(AxisBank&&) noexcept;
  AxisBank& operator=(AxisBank&&) noexcept;

  [[nodiscard]] std::size_t size() const noexcept;
  [[nodiscard]] std::chrono::microseconds period() const noexcept;

  /// Writes an object of axis `axis` (< size()).
  /// @return the CiA 301 abort code of the refusal, or AbortCode::none. Checked in this order:
  ///         index, sub-index, access, range, state.
  AbortCode write(std::size_t axis, ObjectAddress object, std::int64_t value) noexcept;
  AbortCode write(std::size_t axis, ObjectRow row, std::int64_t value) noexcept;

  /// @return what `write` would return now. Changes nothing.
  [[nodiscard]] AbortCode check(std::size_t axis, ObjectRow row, std::int64_t value) const noexcept;

  /// Reads an object of axis `axis` (< size()).
  [[nodiscard]] ReadResult read(std::size_t axis, ObjectAddress object) const noexcept;
  [[nodiscard]] ReadResult read(std::size_t axis, ObjectRow row) const noexcept;

  /// One tick of all axes.
  void step() noexcept;

  /// Axes are stepped in independent groups of equal cost; distinct groups may be stepped at the
  /// same time from several threads. A tick is complete when each group was stepped once.
  [[nodiscard]] std::size_t group_count() const noexcept;
  void step_groups(std::size_t first, std::size_t last) noexcept;
  /// @return the group in which an axis is stepped.
  [[nodiscard]] std::size_t group_of(std::size_t axis) const noexcept;

  /// @return the status image of the last tick.
  [[nodiscard]] const AxisStatus& status(std::size_t axis) const noexcept;
  /// @return the status images of all axes in their order. They stay where they are while this bank
  ///         lives and is neither moved from nor assigned to.
  [[nodiscard]] std::span<const AxisStatus> statuses() const noexcept;
  /// @return the state now, writes since the last step included.
  [[nodiscard]] PowerState power_state(std::size_t axis) const noexcept;

  /// @return rising edges of controlword bit 4 that were not accepted since power-up, writes since
  ///         the last step included.
  [[nodiscard]] std::uint32_t ignored_set_points(std::size_t axis) const noexcept;

  /// As after power-up, the mechanical position kept: registers take their initial values and then
  /// what is stored, faults and the error history are gone, 6061h = 0. Not ready to switch on shows
  /// until the next step.
  void power_cycle(std::size_t axis) noexcept;

  /// From the next tick on the load torque of the axis has white noise beside test_load_torque:
  /// another torque each tick, near a normal distribution, at most 3.47 times `rms`. It depends on
  /// `seed`, `axis` and the ticks since this call alone, and is part of a snapshot. It
  /// outlasts a power cycle.
  /// @param rms root mean square, 0 to kLargestLoadNoise [N.m], at the load shaft; 0 = no noise
  void set_load_noise(std::size_t axis, double rms, std::uint64_t seed) noexcept;

  /// The parameter memory of an axis, which outlasts a power cycle. A bank never fills it itself:
  /// writing 1010h and 1011h with the right signature is accepted and does nothing more. The
  /// owner of the bank makes the values durable first, then makes these calls.
  ///
  /// @return AbortCode::none when 1010h could store this value of this object, else the code of the
  ///         dictionary, or AbortCode::cannot_store_or_transfer where the object is not stored.
  [[nodiscard]] static AbortCode check_stored(ObjectAddress object, std::int64_t value) noexcept;
  /// Reads what 1010h would store now: the values of kStoredRows of
  /// vdrive/dictionary/dictionary.hpp.
  /// @param values one for each of kStoredRows
  void read_parameters(std::size_t axis, std::span<std::int64_t> values) const noexcept;
  /// From the next power-up on the object has this value.
  /// @return that of `check_stored`; where it is not none nothing has changed.
  AbortCode set_stored(std::size_t axis, ObjectAddress object, std::int64_t value) noexcept;
  /// Nothing is stored for the axis any more, and a memory error is over: from the next power-up on
  /// it has its initial values.
  void forget_stored(std::size_t axis) noexcept;

  /// The master of this axis fell silent: reacts per 6007h in Operation enabled and Quick stop
  /// active, else does nothing. Latched as fault 8130h where 6007h = 1.
  void report_connection_loss(std::size_t axis) noexcept;

  /// Copy of the whole state, to be given back to `restore` of a bank built from the same
  /// configuration. Allocates.
  class Snapshot;
  [[nodiscard]] Snapshot snapshot() const;
  /// Copies the whole state into a snapshot of this bank. Allocates nothing.
  void save(Snapshot& snapshot) const;
  /// @return how many bytes Snapshot::bytes() returns for this bank.
  [[nodiscard]] std::size_t snapshot_size() const noexcept;
  /// Copies the whole state as Snapshot::bytes() returns it. Allocates nothing.
  /// @param bytes snapshot_size() of them
  void save(std::span<std::byte> bytes) const noexcept;
  /// What becomes of the parameter memories when a snapshot is restored.
  enum class Memory : std::uint8_t { of_snapshot, kept };
  /// @throws std::invalid_argument when the snapshot is of another number of axes or period.
  void restore(const Snapshot& snapshot, Memory memory = Memory::of_snapshot);

  /// @return a number that stands for the form of `Snapshot::bytes` in this version: what was
  ///         written under another one cannot be read.
  [[nodiscard]] static std::uint64_t snapshot_layout() noexcept;
  /// @param bytes of a snapshot of a bank built from the same configuration, under the same layout
  /// @throws std::invalid_argument when the bytes cannot be a snapshot of this bank.
  [[nodiscard]] Snapshot snapshot_from(std::span<const std::byte> bytes) const;

  /// @return the `image` of StatusDigest over every status image, to compare runs.
  [[nodiscard]] std::uint64_t status_hash() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// State of a bank at one instant.
class AxisBank::Snapshot {
 public:
  Snapshot(const Snapshot& other);
  Snapshot& operator=(const Snapshot& other);
  Snapshot(Snapshot&&) noexcept;
  Snapshot& operator=(Snapshot&&) noexcept;
  ~Snapshot();

  /// @return the state as bytes, for a file on this kind of machine. What follows from the bank's
  ///         configuration is not part of them. Equal states are equal bytes.
  [[nodiscard]] std::vector<std::byte> bytes() const;

 private:
  friend class AxisBank;
  explicit Snapshot(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace vdrive

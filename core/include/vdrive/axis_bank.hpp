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

/// Result of a read: `value` is valid when `code` is AbortCode::none, otherwise it is 0.
struct ReadResult {
  AbortCode code = AbortCode::none;
  std::int64_t value = 0;
};

/// Shortest and longest tick period.
inline constexpr std::chrono::microseconds kShortestPeriod{125};
inline constexpr std::chrono::microseconds kLongestPeriod{10'000};

/// Largest root mean square of the load noise [N.m], see AxisBank::set_load_noise.
inline constexpr double kLargestLoadNoise = 1.0e4;

/// A group of CiA 402 axes that are stepped together. 6502h lists their operating modes.
///
/// A step is a function of the state and of the writes since the last step; it produces the status
/// image of each axis. `write`, `read` and `step` use no clock, thread, lock, allocation or
/// exception. The same writes give bit-identical results for every vector width, every partition of
/// `step_groups` and every build.
///
/// Between two steps, writes take effect in the order of the calls: the power state machine and the
/// set-point handshake run once for every controlword, so several words written within one tick
/// have the same effect as words written in successive ticks. Written objects read back
/// immediately; computed objects show the last tick.
class AxisBank {
 public:
  /// Powers up every axis: afterwards transitions 0 and 1 are done and the status images are valid.
  /// @throws std::invalid_argument when `axes` is empty, the period is outside 125 µs to 10 ms, a
  ///         model parameter is out of range (the message gives parameter, value, unit and limit),
  ///         or the dictionary refuses an initial or stored value.
  AxisBank(std::span<const AxisConfiguration> axes, std::chrono::microseconds period);
  ~AxisBank();
  AxisBank(const AxisBank& other);
  AxisBank& operator=(const AxisBank& other);
  AxisBank(AxisBank&&) noexcept;
  AxisBank& operator=(AxisBank&&) noexcept;

  [[nodiscard]] std::size_t size() const noexcept;
  [[nodiscard]] std::chrono::microseconds period() const noexcept;

  /// Writes an object of axis `axis` (< size()).
  /// @return AbortCode::none, or the CiA 301 abort code of the refusal. Checked in this order:
  ///         index, sub-index, access, range, state.
  AbortCode write(std::size_t axis, ObjectAddress object, std::int64_t value) noexcept;
  AbortCode write(std::size_t axis, ObjectRow row, std::int64_t value) noexcept;

  /// @return what `write` would return now, without writing.
  [[nodiscard]] AbortCode check(std::size_t axis, ObjectRow row, std::int64_t value) const noexcept;

  /// Reads an object of axis `axis` (< size()).
  [[nodiscard]] ReadResult read(std::size_t axis, ObjectAddress object) const noexcept;
  [[nodiscard]] ReadResult read(std::size_t axis, ObjectRow row) const noexcept;

  /// Advances all axes by one tick.
  void step() noexcept;

  /// Axes are divided into independent groups of similar cost. Different groups may be stepped
  /// concurrently by several threads. A tick is complete when every group has been stepped once.
  [[nodiscard]] std::size_t group_count() const noexcept;
  void step_groups(std::size_t first, std::size_t last) noexcept;
  /// @return the group that an axis belongs to.
  [[nodiscard]] std::size_t group_of(std::size_t axis) const noexcept;

  /// @return the status image of the last tick.
  [[nodiscard]] const AxisStatus& status(std::size_t axis) const noexcept;
  /// @return the status images of all axes, in axis order. The span stays valid while this bank
  ///         lives and is neither moved from nor assigned to.
  [[nodiscard]] std::span<const AxisStatus> statuses() const noexcept;
  /// @return the current power state, including writes since the last step.
  [[nodiscard]] PowerState power_state(std::size_t axis) const noexcept;

  /// @return the number of rising edges of controlword bit 4 since power-up that were not accepted,
  ///         including writes since the last step.
  [[nodiscard]] std::uint32_t ignored_set_points(std::size_t axis) const noexcept;

  /// Restarts the axis as after power-up but keeps its mechanical position: registers take their
  /// initial values, then the stored ones; faults and the error history are cleared; 6061h = 0. The
  /// state is Not ready to switch on until the next step.
  void power_cycle(std::size_t axis) noexcept;

  /// Adds white noise to the load torque of an axis, on top of test_load_torque, starting with the
  /// next tick: a new value each tick, nearly normally distributed, at most 3.47 times `rms`. The
  /// sequence depends only on `seed`, `axis` and the number of ticks since this call. The noise is
  /// part of a snapshot and outlasts a power cycle.
  /// @param rms root mean square, 0 to kLargestLoadNoise [N.m], at the load shaft; 0 = no noise
  void set_load_noise(std::size_t axis, double rms, std::uint64_t seed) noexcept;

  /// The parameter memory of an axis, which outlasts a power cycle. The bank never fills it itself:
  /// a write of 1010h or 1011h with the right signature is accepted but has no further effect. The
  /// owner of the bank first makes the values durable, then calls the functions below.
  ///
  /// @return AbortCode::none when 1010h could store this value of this object;
  ///         AbortCode::cannot_store_or_transfer when the object is not stored; otherwise the abort
  ///         code of the dictionary.
  [[nodiscard]] static AbortCode check_stored(ObjectAddress object, std::int64_t value) noexcept;
  /// Reads the values that 1010h would store now, those of kStoredRows in
  /// vdrive/dictionary/dictionary.hpp.
  /// @param values one for each of kStoredRows
  void read_parameters(std::size_t axis, std::span<std::int64_t> values) const noexcept;
  /// Stores a value that an object takes at the next power-up.
  /// @return the result of `check_stored`; nothing changes unless it is AbortCode::none.
  AbortCode set_stored(std::size_t axis, ObjectAddress object, std::int64_t value) noexcept;
  /// Clears the parameter memory of the axis and its memory error; from the next power-up on the
  /// axis has its initial values.
  void forget_stored(std::size_t axis) noexcept;

  /// Reports that the master of this axis has stopped sending. In Operation enabled and Quick stop
  /// active the axis reacts as 6007h says; in other states it does nothing. With 6007h = 1, fault
  /// 8130h is latched.
  void report_connection_loss(std::size_t axis) noexcept;

  /// A copy of the complete state, for `restore` of a bank built from the same configuration.
  /// Allocates.
  class Snapshot;
  [[nodiscard]] Snapshot snapshot() const;
  /// Copies the complete state into a snapshot of this bank. Does not allocate.
  void save(Snapshot& snapshot) const;
  /// @return the number of bytes that Snapshot::bytes() returns for this bank.
  [[nodiscard]] std::size_t snapshot_size() const noexcept;
  /// Writes the complete state in the form of Snapshot::bytes(). Does not allocate.
  /// @param bytes exactly snapshot_size() bytes
  void save(std::span<std::byte> bytes) const noexcept;
  /// Whether a restore replaces the parameter memories or keeps them.
  enum class Memory : std::uint8_t { of_snapshot, kept };
  /// @throws std::invalid_argument when the snapshot has another number of axes or another period.
  void restore(const Snapshot& snapshot, Memory memory = Memory::of_snapshot);

  /// @return a number that identifies the layout of `Snapshot::bytes` in this version. Bytes
  ///         written under another layout cannot be read.
  [[nodiscard]] static std::uint64_t snapshot_layout() noexcept;
  /// @param bytes a snapshot of a bank built from the same configuration, with the same layout
  /// @throws std::invalid_argument when the bytes cannot be a snapshot of this bank.
  [[nodiscard]] Snapshot snapshot_from(std::span<const std::byte> bytes) const;

  /// @return the `image` of StatusDigest over all status images, to compare runs.
  [[nodiscard]] std::uint64_t status_hash() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The state of a bank at one instant.
class AxisBank::Snapshot {
 public:
  Snapshot(const Snapshot& other);
  Snapshot& operator=(const Snapshot& other);
  Snapshot(Snapshot&&) noexcept;
  Snapshot& operator=(Snapshot&&) noexcept;
  ~Snapshot();

  /// @return the state as bytes, for a file on a machine of the same kind. Anything derived from
  ///         the configuration of the bank is left out. Equal states give equal bytes.
  [[nodiscard]] std::vector<std::byte> bytes() const;

 private:
  friend class AxisBank;
  explicit Snapshot(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace vdrive

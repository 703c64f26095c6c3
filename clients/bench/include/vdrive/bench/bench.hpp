// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_configuration.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/clock_mode.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::bench {

/// Thrown when a bench cannot be created as requested. The message names the setting, its place,
/// its value and the limit.
class BenchError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

inline constexpr std::size_t kMostAxes = 16'384;         ///< per bench; at least 1
inline constexpr std::uint32_t kHighestNumber = 65'535;  ///< of a bench; the lowest is 1

/// The configuration has a network setting, which a bench in this process does not support.
class NeedsNetwork : public BenchError {
 public:
  using BenchError::BenchError;
};

/// @return the machines that BenchOptions::preset may name, such as "ball-screw", in alphabetical
///         order.
[[nodiscard]] std::vector<std::string> preset_names();

/// The options of a bench. The defaults are the demo bench of vdrived: two axes with the default
/// motor and load, in lock-step.
struct BenchOptions {
  /// YAML as in the file of vdrived (docs/guides/configuration.md); empty = defaults. Network
  /// settings are refused: `network`, `metrics`, `wire`.
  std::string configuration{};
  std::filesystem::path configuration_file{};  ///< instead of `configuration`
  std::optional<std::size_t> axes{};  ///< 1 to kMostAxes default axes, instead of configured ones
  /// Type of machine for the axes (docs/reference/presets.md); one axis if `axes` is not set. Empty
  /// = none.
  std::string preset{};
  /// Motor, load and settings of each axis, instead of the configured ones; not together with
  /// `axes` or `preset`. 1 to kMostAxes; the bench assigns numbers (from 1), names ("axis1", ...)
  /// and serial numbers. Empty = none.
  std::vector<AxisConfiguration> axis_configurations{};
  /// Length of a tick, 125 us to 10 ms. Nothing = as configured, by default 1 ms.
  std::optional<std::chrono::microseconds> period{};
  /// Nothing = as configured, by default lock-step.
  std::optional<ClockMode> clock{};
  std::optional<std::uint32_t> number{};    ///< of the bench, 1 to kHighestNumber
  std::filesystem::path state_directory{};  ///< where parameters can be stored; empty = nowhere
  std::filesystem::path journal{};          ///< file for a later replay; empty = none
  std::shared_ptr<wire::LocalBus> bus{};    ///< the bus of another bench; null = a new one
};

/// Checks the options and the configuration as a bench would, without creating one.
/// @throws BenchError, NeedsNetwork if no bench can be created with these options.
void check(const BenchOptions& options);

/// A bench of virtual drives inside this process: the same drives, clock and control as in vdrived,
/// but without a network. Sessions reach it through its bus, with the same interfaces.
///
/// In lock-step it runs in the threads of the calls that wait for it, such as a step. In realtime
/// and freerun it has its own threads. A state directory and a journal each add a thread and a
/// file; without them, a bench in lock-step has no thread, and no bench opens a file.
///
/// Thread-safe, except for construction and destruction. Destroying it ends the bench, even while
/// axes move and sessions wait: their calls then return `lost` immediately.
///
/// A forked process cannot use the bench of its parent: sessions return `lost` there, and nothing
/// is destroyed. It may create its own benches.
class Bench {
 public:
  /// @throws BenchError if an option is invalid, a file cannot be read, another bench on the bus
  ///         has this number, or another bench uses the state directory or the journal.
  explicit Bench(const BenchOptions& options = {});
  ~Bench();
  Bench(Bench&& other) noexcept;
  Bench& operator=(Bench&& other) noexcept;
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  /// The bus through which sessions and further benches reach this one.
  /// @throws BenchError in a forked process
  [[nodiscard]] std::shared_ptr<wire::LocalBus> bus() const;

  /// @return a session on the bus of this bench.
  /// @throws as Session does; BenchError in a forked process
  [[nodiscard]] client::Session session(client::SessionOptions options = {}) const;

  [[nodiscard]] std::uint32_t number() const noexcept;

 private:
  class Parts;

  struct End {
    void operator()(Parts* parts) const noexcept;
  };

  void require_own_process() const;

  std::unique_ptr<Parts, End> parts_;
};

}  // namespace vdrive::bench

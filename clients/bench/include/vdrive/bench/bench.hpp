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

/// A bench cannot be made as it was asked for. The message names what, where, the value and the
/// limit.
class BenchError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

inline constexpr std::size_t kMostAxes = 16'384;         ///< of a bench; the fewest are 1
inline constexpr std::uint32_t kHighestNumber = 65'535;  ///< of a bench; the lowest is 1

/// The configuration has a key about a network, which a bench in a process has not.
class NeedsNetwork : public BenchError {
 public:
  using BenchError::BenchError;
};

/// @return the machines that BenchOptions::preset may name, such as "ball-screw", in alphabetical
///         order.
[[nodiscard]] std::vector<std::string> preset_names();

/// What a bench is made of. The defaults are the demo bench of vdrived, two axes of the default
/// motor and load, in lock-step.
struct BenchOptions {
  /// YAML as in the file of vdrived (docs/guides/configuration.md); empty = defaults. What is about
  /// a network is refused: `network`, `metrics`, `wire`.
  std::string configuration{};
  std::filesystem::path configuration_file{};  ///< instead of `configuration`
  std::optional<std::size_t> axes{};           ///< 1 to kMostAxes default axes, instead of its own
  /// The axes are of this machine (docs/reference/presets.md), one without `axes`; empty = none.
  std::string preset{};
  /// Motor, load and settings of each axis, instead of those of the configuration; not with `axes`
  /// or `preset`. 1 to kMostAxes, whose numbers (from 1), names ("axis1", ...) and serial numbers
  /// the bench gives. Empty = none.
  std::vector<AxisConfiguration> axis_configurations{};
  /// Of a tick, 125 us to 10 ms. Nothing = that of the configuration, or without one 1 ms.
  std::optional<std::chrono::microseconds> period{};
  /// Nothing = that of the configuration, or without one lock-step.
  std::optional<ClockMode> clock{};
  std::optional<std::uint32_t> number{};    ///< of the bench, 1 to kHighestNumber
  std::filesystem::path state_directory{};  ///< parameters can be stored here; empty = nowhere
  std::filesystem::path journal{};          ///< file that a replay reads; empty = none
  std::shared_ptr<wire::LocalBus> bus{};    ///< of another bench; empty = one of its own
};

/// Reads the configuration as a bench does, and makes none.
/// @throws BenchError, NeedsNetwork where a bench cannot be of these options.
void check(const BenchOptions& options);

/// A bench of virtual drives inside this process: the same drives, clock and control as those of
/// vdrived, without a network. Sessions reach it by its bus, through the same interfaces.
///
/// In lock-step its work runs in the threads of the calls that wait for it, such as a step. In
/// realtime and freerun it has threads of its own. A state directory and a journal have a thread
/// and a file each; without them a bench in lock-step has no thread, and none opens a file.
///
/// Thread-safe but for construction and destruction. It ends when it is destroyed, also while axes
/// move and while sessions wait: their calls then return Lost, at once.
///
/// A process that was forked leaves the bench to its parent: sessions return Lost there, and
/// nothing is destroyed. It may make benches of its own.
class Bench {
 public:
  /// @throws BenchError when an option is bad, a file cannot be read, another bench on the bus has
  ///         this number, or another bench uses the state directory or the journal.
  explicit Bench(const BenchOptions& options = {});
  ~Bench();
  Bench(Bench&& other) noexcept;
  Bench& operator=(Bench&& other) noexcept;
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  /// What sessions and further benches need to meet this one.
  /// @throws BenchError in a forked process
  [[nodiscard]] std::shared_ptr<wire::LocalBus> bus() const;

  /// @return a session on the bus of this bench.
  /// @throws what Session throws, BenchError in a forked process
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

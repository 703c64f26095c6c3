// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "simulation/bench.hpp"
#include "simulation/happenings.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>

namespace vdrive::simulation {

/// The scope of a run.
enum class Play : std::uint8_t {
  everything,  ///< two masters, all disturbances; clock by the seed
  fight,       ///< two masters that keep taking the axes from each other, and a bad network
};

struct Options {
  std::uint64_t seed = 1;
  double seconds = 60.0;  ///< drive time
  std::size_t axes = 16;
  std::size_t threads = 1;  ///< that step the bank
  Play play = Play::everything;
  std::optional<service::ClockMode> clock = std::nullopt;  ///< nullopt = the seed chooses
  std::uint64_t stop_at_tick = 0;                          ///< 0 = at the end
  std::ostream* trace = nullptr;
  Sabotage sabotage = Sabotage::none;
};

/// The result of a seed.
struct Report {
  std::uint64_t seed = 0;
  std::uint64_t ticks = 0;
  double seconds = 0.0;    ///< drive time
  std::uint64_t hash = 0;  ///< of everything that happened
  std::optional<Violation> violation;
  std::uint64_t commands = 0;  ///< executed, counted per axis
  std::uint64_t refused_frames = 0;
  std::uint64_t lost_masters = 0;
  std::uint64_t jumps = 0;
  std::uint64_t restarts = 0;       ///< of the service
  std::uint64_t stores = 0;         ///< acknowledged, counted per axis
  std::uint64_t failed_stores = 0;  ///< refused, counted per axis
  std::uint64_t cut_saves = 0;      ///< saves in which the service ended

  void add(const Report& other);
};

/// Plays the seed, which determines everything; stops at the first violation.
[[nodiscard]] Report simulate(const Options& options);

}  // namespace vdrive::simulation

// SPDX-License-Identifier: Apache-2.0
#include "program/bench_probes.hpp"

#include "run/standstill.hpp"

#include <memory>
#include <optional>
#include <string>

namespace vdrive::service {
namespace {

constexpr const char* kNotAnnounced = "is starting or stopping";

std::string seconds_text(Standstill::Clock::duration time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::seconds>(time).count()) + " s";
}

/// A bench counts as alive while it starts or ends, because neither can last forever.
ProbeAnswer alive(const BenchRun& run, std::optional<Standstill>& standstill) {
  const std::string bench = "bench " + std::to_string(run.identity().bench) + " ";
  if (!run.is_announced()) return {.is_good = true, .text = bench + kNotAnnounced};
  const auto now = Standstill::Clock::now();
  if (!standstill) standstill.emplace(run.beats(), now);
  const Standstill::Longest longest = standstill->look(now);
  if (longest.time <= kLongestStandstill) return {.is_good = true, .text = bench + "is alive"};
  return {.is_good = false,
          .text = bench + "hangs: no progress for " + seconds_text(longest.time) + " (" +
                  std::string(longest.name) + ")"};
}

ProbeAnswer ready(const BenchRun& run) {
  const std::string bench = "bench " + std::to_string(run.identity().bench) + " ";
  if (!run.is_announced()) return {.is_good = false, .text = bench + kNotAnnounced};
  if (!run.has_run()) return {.is_good = false, .text = bench + "has run no tick yet"};
  if (!run.is_reachable()) {
    return {.is_good = false, .text = bench + "has no network: the network process is down"};
  }
  return {.is_good = true, .text = bench + "is on the network"};
}

}  // namespace

Probes probes_of(const BenchRun& run) {
  return {.is_alive =
              [&run, standstill = std::optional<Standstill>()]() mutable {
                return alive(run, standstill);
              },
          .is_ready =
              [&run] {
                return ready(run);
              }};
}

}  // namespace vdrive::service

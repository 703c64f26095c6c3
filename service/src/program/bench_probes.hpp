// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/metrics_endpoint.hpp"
#include "run/bench_run.hpp"

#include <chrono>

namespace vdrive::service {

/// A thread of a bench that has completed nothing for so long is not alive.
inline constexpr std::chrono::seconds kLongestStandstill{5};

/// @return what a bench answers: it is alive while its threads make progress, and ready while it is
/// announced and its network runs.
/// @param run outlives the answer
[[nodiscard]] Probes probes_of(const BenchRun& run);

}  // namespace vdrive::service

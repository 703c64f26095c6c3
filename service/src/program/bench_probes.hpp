// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/metrics_endpoint.hpp"
#include "run/bench_run.hpp"

#include <chrono>

namespace vdrive::service {

/// A bench is not alive if one of its threads has completed nothing for this long.
inline constexpr std::chrono::seconds kLongestStandstill{5};

/// @return the probes of a bench: it is alive while its threads make progress, and ready while it
///         is announced and its network runs.
/// @param run outlives the returned object
[[nodiscard]] Probes probes_of(const BenchRun& run);

}  // namespace vdrive::service

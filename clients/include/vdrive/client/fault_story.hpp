// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"
#include "vdrive/client/history.hpp"

#include <functional>
#include <string>
#include <vector>

namespace vdrive::client {

/// Why an axis faulted, in readable sentences.
struct FaultStory {
  std::string title;               ///< such as "axis 1.2: 8611h following error at tick 5204"
  std::vector<std::string> lines;  ///< the events in the window that led to it, nearest cause first
  std::string remedy;              ///< what to check; empty if nothing is known
};

/// Returns the display name of a session, such as "vdrive (process 4711 on bench-host)".
using SessionText = std::function<std::string(std::uint64_t session)>;

/// Explains what led to one of the causes of a window. It states only what the window shows:
/// test-bench inputs that acted, limits that were exceeded and for how long, the last command and
/// who gave it.
/// @param window must contain the axis of the cause
/// @param bench the bench that recorded it
[[nodiscard]] FaultStory story_of(const Window& window, const WindowCause& cause,
                                  const BenchInfo& bench, const SessionText& name_of);

}  // namespace vdrive::client

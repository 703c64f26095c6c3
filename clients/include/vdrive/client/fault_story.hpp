// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"
#include "vdrive/client/history.hpp"

#include <functional>
#include <string>
#include <vector>

namespace vdrive::client {

/// Why an axis faulted, in sentences for people.
struct FaultStory {
  std::string title;               ///< such as "axis 1.2: 8611h following error at tick 5204"
  std::vector<std::string> lines;  ///< what in this window led to it, the nearest cause first
  std::string remedy;              ///< what to look at; empty where nothing is known
};

/// What people call a session, such as "vdrive (process 4711 on bench-host)".
using SessionText = std::function<std::string(std::uint64_t session)>;

/// Tells what led to one of the causes of a window. It says nothing that the window does not show:
/// inputs of the test bench that acted, limits that were passed and for how long, the last
/// command and who gave it.
/// @param window has the axis of the cause
/// @param bench that has recorded it
[[nodiscard]] FaultStory story_of(const Window& window, const WindowCause& cause,
                                  const BenchInfo& bench, const SessionText& name_of);

}  // namespace vdrive::client

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace vdrive::canopen {

/// Drive time since a bench began, as the caller counts it: heartbeats, inhibit times and event
/// timers of a node count it.
using DriveTime = std::chrono::microseconds;

}  // namespace vdrive::canopen

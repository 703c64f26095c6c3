// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace vdrive::canopen {

/// Drive time as the bench counts it (in real time since 1970): only differences have a meaning to
/// a node. Its heartbeats, inhibit times and event timers count it.
using DriveTime = std::chrono::microseconds;

}  // namespace vdrive::canopen

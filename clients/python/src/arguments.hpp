// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/dictionary/object.hpp"

#include <chrono>
#include <cstdint>

/// Conversions between plain values, already checked by the package, and those of the client
/// library.
namespace vdrive::python {

/// @param nanoseconds 0 to 100 years
/// @return the duration, rounded up to milliseconds.
[[nodiscard]] inline std::chrono::milliseconds milliseconds_of(std::int64_t nanoseconds) {
  return std::chrono::ceil<std::chrono::milliseconds>(std::chrono::nanoseconds(nanoseconds));
}

/// @return [s]
[[nodiscard]] inline double seconds_of(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

/// @param timeout [ns] drive time
[[nodiscard]] inline client::CallOptions call_options(std::int64_t timeout, bool in_force) {
  return {.timeout = std::chrono::nanoseconds(timeout),
          .until = in_force ? client::Until::in_force : client::Until::done};
}

[[nodiscard]] inline client::Pace pace_of(bool observes) {
  return observes ? client::Pace::observe : client::Pace::drive;
}

inline constexpr unsigned kSubindexBits = 8;

/// @param object index and, in the lowest byte, sub-index
[[nodiscard]] inline ObjectAddress object_of(std::uint32_t object) {
  return {.index = static_cast<std::uint16_t>(object >> kSubindexBits),
          .subindex = static_cast<std::uint8_t>(object)};
}

}  // namespace vdrive::python

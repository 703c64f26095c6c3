// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <chrono>
#include <cstddef>

namespace vdrive::service {

/// How much drive time of status is buffered while a thread or process gets no processor time;
/// longer pauses lose status.
inline constexpr std::chrono::milliseconds kStatusHeld{250};

/// How much status may wait on its way to the network.
struct StatusDepth {
  std::size_t images = 0;  ///< between the tick thread and the status thread
  std::size_t room = 0;    ///< between engine and wire, a power of two [bytes]
};

/// The maximum memory for the waiting images [bytes]; there is room for 4 images in any case.
inline constexpr std::size_t kMaxImageMemory = std::size_t{64} << 20U;

/// The maximum room between engine and wire [bytes].
inline constexpr std::size_t kMostRoom = std::size_t{128} << 20U;

/// @return the depth that holds kStatusHeld of a bench, within the limits above.
[[nodiscard]] StatusDepth status_depth(const Configuration& configuration);

}  // namespace vdrive::service

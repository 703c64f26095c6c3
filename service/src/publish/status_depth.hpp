// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <chrono>
#include <cstddef>

namespace vdrive::service {

/// Status of this drive time waits for a thread or a process that gets no processor time; longer
/// pauses lose status.
inline constexpr std::chrono::milliseconds kStatusHeld{250};

/// How much status waits on its way to the network.
struct StatusDepth {
  std::size_t images = 0;  ///< between the tick thread and the status thread
  std::size_t room = 0;    ///< between engine and wire, a power of two [bytes]
};

/// Most memory that the images of all axes take [bytes]; a bench has room for 4 in any case.
inline constexpr std::size_t kMostOfImages = std::size_t{64} << 20U;

/// Most room between engine and wire [bytes].
inline constexpr std::size_t kMostRoom = std::size_t{128} << 20U;

/// @return what holds kStatusHeld of a bench, within the limits above.
[[nodiscard]] StatusDepth status_depth(const Configuration& configuration);

}  // namespace vdrive::service

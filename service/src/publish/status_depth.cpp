// SPDX-License-Identifier: Apache-2.0
#include "publish/status_depth.hpp"

#include "publish/status_publisher.hpp"
#include "seam/byte_ring.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive/wire/status_frame.hpp"
#include "vdrive_messages.hpp"

#include <algorithm>
#include <bit>

namespace vdrive::service {
namespace {

constexpr std::size_t kLeastImages = 4;
constexpr std::size_t kMostImages = 4'096;  ///< one axis at 125 us needs 2,000
constexpr std::size_t kLeastRoom = std::size_t{1} << 20U;

/// @return the room that one tick takes between engine and wire [bytes].
std::size_t bytes_of_a_tick(std::size_t axes) {
  constexpr std::size_t kFrame = msg::MAX_AXES_PER_FRAME;
  constexpr std::size_t kHead = sizeof(RecordHead) + sizeof(std::uint64_t);
  const std::size_t rest = axes % kFrame;
  return axes / kFrame * (wire::encoded_status_frame_size(kFrame) + kHead) +
         (rest == 0 ? 0 : wire::encoded_status_frame_size(rest) + kHead);
}

}  // namespace

StatusDepth status_depth(const Configuration& configuration) {
  const std::size_t axes = configuration.axes.size();
  const auto interval = configuration.period * configuration.status_every;
  const std::size_t images =
      configuration.clock == ClockMode::realtime
          ? static_cast<std::size_t>(std::chrono::microseconds(kStatusHeld) / interval) + 1
          : kLeastImages;
  const std::size_t fitting =
      kMaxImageMemory / (axes * (sizeof(AxisStatus) + sizeof(wire::Ownership)));
  // Axis samples use the same lane, at the rate limit of their publisher.
  const auto samples = static_cast<std::size_t>(StatusPublisher::kAxisSamples.per_second *
                                                std::chrono::duration<double>(kStatusHeld).count());
  const std::size_t room =
      images * bytes_of_a_tick(axes) + samples * (wire::kAxisStatusSize + sizeof(RecordHead));
  return {.images = std::clamp(std::min(images, fitting), kLeastImages, kMostImages),
          .room = std::bit_ceil(std::clamp(room, kLeastRoom, kMostRoom))};
}

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive {

enum class StreamStage : std::uint8_t {
  none,    // the set-point has not been written since the mode became active
  begins,  // it has been written, but no tick has taken it yet
  runs,
};

/// Cyclic modes and interpolated position: the stream of set-points.
struct StreamState {
  StreamStage stage = StreamStage::none;
  bool written = false;  // whether a set-point was written since a tick last took one
};

}  // namespace vdrive

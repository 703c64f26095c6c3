// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judge.hpp"
#include "log/bus_decoder.hpp"
#include "log/log_line.hpp"

#include <cstdint>
#include <functional>
#include <istream>
#include <string>
#include <vector>

namespace vdrive::judge {

/// Numbers of lines in a log, by kind.
struct LogCounts {
  std::uint64_t lines = 0;
  std::uint64_t broken = 0;            ///< truncated, or in another format
  std::uint64_t first_broken = 0;      ///< the line number, from 1
  std::uint64_t foreign = 0;           ///< CAN FD, error frames
  std::uint64_t backwards = 0;         ///< times earlier than in the previous line
  std::uint64_t other_interfaces = 0;  ///< frames of buses other than that of the first frame
};

/// The result of judging a bus log.
struct LogVerdict {
  Verdict verdict;
  LogCounts lines;
  DecoderCounts frames;
  std::vector<std::string> notes;  ///< what the log lacks, and what was left out, one per line

  /// @return whether it was a log at all: it contains a frame.
  [[nodiscard]] bool is_readable() const noexcept {
    return frames.frames + lines.other_interfaces > 0;
  }
};

/// Called with each frame of the judged bus: the number of its line, and its kind.
using FrameWatcher = std::function<void(std::uint64_t line, const DecodedFrame& frame)>;

/// Reads a log from beginning to end, in bounded memory, and judges the masters of its bus. A line
/// that is not a frame is only counted.
[[nodiscard]] LogVerdict judge_bus_log(std::istream& log, const DecoderSettings& settings,
                                       const FrameWatcher& watcher = {});

}  // namespace vdrive::judge

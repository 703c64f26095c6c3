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

/// What became of the lines of a log.
struct LogCounts {
  std::uint64_t lines = 0;
  std::uint64_t broken = 0;            ///< cut, or of another format
  std::uint64_t first_broken = 0;      ///< its number, from 1
  std::uint64_t foreign = 0;           ///< CAN FD, error frames
  std::uint64_t backwards = 0;         ///< times before that of the line before
  std::uint64_t other_interfaces = 0;  ///< frames of other buses than that of the first frame
};

/// What a log of a bus gives.
struct LogVerdict {
  Verdict verdict;
  LogCounts lines;
  DecoderCounts frames;
  std::vector<std::string> notes;  ///< what the log lacks, and what was left out, a line each

  /// @return whether it was a log at all: it has a frame.
  [[nodiscard]] bool is_readable() const noexcept {
    return frames.frames + lines.other_interfaces > 0;
  }
};

/// Is told what each line is: its number, and the frame of LineKind::frame.
using FrameWatcher = std::function<void(std::uint64_t line, const DecodedFrame& frame)>;

/// Reads a log from its beginning to its end, in bounded memory, and judges the masters of its bus.
/// A line that is no frame is counted, and nothing else.
[[nodiscard]] LogVerdict judge_bus_log(std::istream& log, const DecoderSettings& settings,
                                       const FrameWatcher& watcher = {});

}  // namespace vdrive::judge

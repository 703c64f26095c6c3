// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/record.hpp"
#include "node/frame.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

namespace vdrive::judge {

/// A frame of a log.
struct LoggedFrame {
  std::optional<Time> time{};     ///< since the beginning of the log's clock; none = it has none
  std::string_view interface {};  ///< such as "can0"; of an .asc the number of the channel
  canopen::Frame frame{};
};

/// What a line of a log is.
enum class LineKind : std::uint8_t {
  frame,
  nothing,  ///< empty, a comment, a header
  foreign,  ///< CAN FD, an error frame, a message of the logger: read, and not used
  broken,   ///< none of these
};

/// Reads the lines of candump (its log format, as `candump -L` and `-l` write it, and the one for
/// people with any of its time stamps) and those of Vector's .asc. A log may have all of them.
class LogLines {
 public:
  /// @param line without its end
  /// @param frame has the frame where the answer is LineKind::frame; its texts are parts of `line`
  LineKind read(std::string_view line, LoggedFrame& frame);

 private:
  LineKind read_asc(std::string_view line, LoggedFrame& frame);
  bool read_asc_header(std::string_view line);

  bool is_asc_ = false;
  bool is_asc_decimal_ = false;   ///< "base dec"
  bool is_asc_relative_ = false;  ///< "timestamps relative"
  Time asc_time_{};               ///< of the line before
};

}  // namespace vdrive::judge

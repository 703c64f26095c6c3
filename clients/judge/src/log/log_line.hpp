// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/record.hpp"
#include "node/frame.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

namespace vdrive::judge {

struct LoggedFrame {
  std::optional<Time> time{};     ///< since the origin of the log's clock; nothing = no times
  std::string_view interface {};  ///< such as "can0"; in an .asc file the channel number
  canopen::Frame frame{};
};

/// The kind of a line in a log.
enum class LineKind : std::uint8_t {
  frame,
  nothing,  ///< empty, a comment, a header
  foreign,  ///< CAN FD, an error frame, a message of the logger: recognised, but not used
  broken,   ///< none of these
};

/// Parses the lines of candump (its log format, as written by `candump -L` and `-l`, and the
/// readable one with any of its time stamps) and of Vector .asc files. A log may contain all of
/// them.
class LogLines {
 public:
  /// @param line without its line end
  /// @param frame receives the frame if the result is LineKind::frame; its texts point into `line`
  LineKind read(std::string_view line, LoggedFrame& frame);

 private:
  LineKind read_asc(std::string_view line, LoggedFrame& frame);
  bool read_asc_header(std::string_view line);

  bool is_asc_ = false;
  bool is_asc_decimal_ = false;   ///< "base dec"
  bool is_asc_relative_ = false;  ///< "timestamps relative"
  Time asc_time_{};               ///< of the previous line
};

}  // namespace vdrive::judge

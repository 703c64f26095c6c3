// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::canopen {

/// A line of a byte stream, without its end.
struct StreamLine {
  std::string text;
  bool is_too_long = false;  ///< `text` has only the beginning

  friend bool operator==(const StreamLine&, const StreamLine&) = default;
};

/// Splits a byte stream into lines, which end with LF or CR LF.
class LineReader final {
 public:
  /// @param longest limit of a line [bytes]
  explicit LineReader(std::size_t longest) : longest_(longest) {}

  /// Takes bytes in pieces of any length.
  void append(std::string_view bytes);

  /// @return the next complete line; nothing if there is none.
  [[nodiscard]] std::optional<StreamLine> next();

 private:
  void append_to_line(std::string_view bytes);

  std::size_t longest_;
  std::deque<StreamLine> whole_;
  StreamLine line_;  ///< the incomplete last line
};

}  // namespace vdrive::canopen

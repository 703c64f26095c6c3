// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::canopen {

/// A line of a stream of bytes, without its end.
struct StreamLine {
  std::string text;
  bool is_too_long = false;  ///< then `text` has the beginning only

  friend bool operator==(const StreamLine&, const StreamLine&) = default;
};

/// Cuts a stream of bytes into lines, which end with LF or CR LF.
class LineReader final {
 public:
  /// @param longest [bytes] that a line may have
  explicit LineReader(std::size_t longest) : longest_(longest) {}

  /// Takes bytes in parts of any length.
  void append(std::string_view bytes);

  /// @return the next line that is whole; nothing when none is.
  [[nodiscard]] std::optional<StreamLine> next();

 private:
  void append_to_line(std::string_view bytes);

  std::size_t longest_;
  std::deque<StreamLine> whole_;
  StreamLine line_;  ///< that has begun
};

}  // namespace vdrive::canopen

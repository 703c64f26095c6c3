// SPDX-License-Identifier: Apache-2.0
#include "bus/line_reader.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::canopen {

void LineReader::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    append_to_line(bytes.substr(0, end));
    if (end == std::string_view::npos) return;
    if (line_.text.ends_with('\r')) line_.text.pop_back();
    line_.is_too_long = line_.is_too_long || line_.text.size() > longest_;
    whole_.push_back(std::exchange(line_, {}));
    bytes.remove_prefix(end + 1);
  }
}

std::optional<StreamLine> LineReader::next() {
  if (whole_.empty()) return std::nullopt;
  std::optional<StreamLine> line(std::move(whole_.front()));
  whole_.pop_front();
  return line;
}

void LineReader::append_to_line(std::string_view bytes) {
  // One more for CR.
  const std::size_t room = longest_ + 1 - line_.text.size();
  line_.is_too_long = line_.is_too_long || bytes.size() > room;
  line_.text += bytes.substr(0, std::min(bytes.size(), room));
}

}  // namespace vdrive::canopen

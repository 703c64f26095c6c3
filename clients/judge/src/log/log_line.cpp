// SPDX-License-Identifier: Apache-2.0
#include "log/log_line.hpp"

#include "vdrive/number_text.hpp"

#include <algorithm>
#include <cstddef>
#include <span>

namespace vdrive::judge {
namespace {

using canopen::Frame;

constexpr int kHexBase = 16;
constexpr std::int64_t kNanoseconds = 1'000'000'000;
constexpr std::int64_t kLatestSecond = 4'000'000'000;  // the year 2096
constexpr std::size_t kBaseIdDigits = 3;
constexpr std::size_t kExtendedIdDigits = 8;

constexpr bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

/// Removes blanks from the front.
void skip_blanks(std::string_view& text) {
  const auto end = std::ranges::find_if_not(text, is_blank);
  text.remove_prefix(static_cast<std::size_t>(end - text.begin()));
}

/// Removes the next word from the front; empty at the end.
std::string_view take_word(std::string_view& text) {
  skip_blanks(text);
  const auto end = std::ranges::find_if(text, is_blank);
  const std::string_view word = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(word.size());
  return word;
}

/// @return the time written as "12.345" or "1436509052.249713".
std::optional<Time> time_of(std::string_view text) {
  const std::size_t point = text.find('.');
  const auto seconds = parse_digits<std::int64_t>(text.substr(0, point));
  if (!seconds || *seconds < 0 || *seconds > kLatestSecond) return std::nullopt;
  std::int64_t fraction = 0;
  if (point != std::string_view::npos) {
    std::int64_t digit = kNanoseconds / 10;
    for (const char c : text.substr(point + 1)) {
      if (c < '0' || c > '9') return std::nullopt;
      fraction += digit * (c - '0');
      digit /= 10;
    }
  }
  return Time(*seconds * kNanoseconds + fraction);
}

/// @return the time of day written as "08:17:32.249713", which candump -tA puts after a date.
std::optional<Time> time_of_day(std::string_view date, std::string_view text) {
  constexpr std::size_t kSecondsPlace = 6;
  constexpr std::size_t kDateLength = 10;
  constexpr int kHours = 24;
  constexpr int kMinutes = 60;
  constexpr std::chrono::seconds kLeapSecond{60};
  if (text.size() < kSecondsPlace + 2 || text[2] != ':' || date.size() != kDateLength)
    return std::nullopt;
  const auto year = parse_digits<std::uint16_t>(date.substr(0, 4));
  const auto month = parse_digits<std::uint8_t>(date.substr(5, 2));
  const auto day = parse_digits<std::uint8_t>(date.substr(8));
  const auto hours = parse_digits<std::uint8_t>(text.substr(0, 2));
  const auto minutes = parse_digits<std::uint8_t>(text.substr(3, 2));
  const auto seconds = time_of(text.substr(kSecondsPlace));
  if (!year || !day || !month || !hours || !minutes || !seconds) return std::nullopt;
  const std::chrono::year_month_day parsed{std::chrono::year(*year), std::chrono::month(*month),
                                           std::chrono::day(*day)};
  if (!parsed.ok() || *hours >= kHours || *minutes >= kMinutes ||
      *seconds >= kLeapSecond + std::chrono::seconds(1)) {
    return std::nullopt;
  }
  // Local time is not converted, so a change to summer time is a step.
  const auto whole = std::chrono::sys_days(parsed).time_since_epoch() + std::chrono::hours(*hours) +
                     std::chrono::minutes(*minutes);
  if (whole < std::chrono::seconds(0) || whole > std::chrono::seconds(kLatestSecond)) {
    return std::nullopt;
  }
  return whole + *seconds;
}

/// Parses an identifier: candump writes 3 digits for the base format and 8 for the extended format.
bool read_id(std::string_view text, Frame& frame) {
  if (text.size() != kBaseIdDigits && text.size() != kExtendedIdDigits) return false;
  const auto id = parse_digits<std::uint32_t>(text, kHexBase);
  frame.is_extended = text.size() == kExtendedIdDigits;
  const std::uint32_t highest =
      frame.is_extended ? canopen::kHighestExtendedId : canopen::kHighestBaseId;
  if (!id || *id > highest) return false;
  frame.id = *id;
  return true;
}

std::optional<std::uint8_t> byte_of(std::string_view text) {
  return text.size() == 2 ? parse_digits<std::uint8_t>(text, kHexBase) : std::nullopt;
}

/// Parses "0011AA", also with dots between the bytes; for a remote frame "R" or "R8".
bool read_packed(std::string_view text, Frame& frame) {
  if (text.starts_with('R')) {
    frame.is_remote = true;
    const auto size = text.size() == 1 ? std::optional<std::uint8_t>(std::uint8_t{0})
                                       : parse_digits<std::uint8_t>(text.substr(1));
    frame.size = std::min(size.value_or(canopen::kMostData), std::uint8_t{canopen::kMostData});
    return size && *size <= canopen::kMostData;
  }
  std::size_t count = 0;
  while (!text.empty()) {
    const auto byte = byte_of(text.substr(0, 2));
    if (!byte || count == canopen::kMostData) return false;
    frame.data[count++] = *byte;
    text.remove_prefix(2);
    if (text.starts_with('.')) text.remove_prefix(1);
  }
  frame.size = static_cast<std::uint8_t>(count);
  return true;
}

/// Parses `count` bytes, each a separate word.
bool read_bytes(std::string_view& text, std::uint8_t count, int base, Frame& frame) {
  for (std::uint8_t i = 0; i < count; ++i) {
    const std::string_view word = take_word(text);
    const auto byte = base == kHexBase ? byte_of(word) : parse_digits<std::uint8_t>(word);
    if (!byte) return false;
    frame.data.at(i) = *byte;
  }
  frame.size = count;
  return true;
}

/// Parses "123#0011", after the interface.
LineKind read_log_format(std::string_view id_and_data, LoggedFrame& frame) {
  const std::size_t hash = id_and_data.find('#');
  const std::string_view data = id_and_data.substr(hash + 1);
  if (data.starts_with('#')) return LineKind::foreign;  // CAN FD
  constexpr std::uint32_t kErrorFlag = 0x20000000;
  const std::string_view id = id_and_data.substr(0, hash);
  if (id.size() == kExtendedIdDigits) {
    const auto number = parse_digits<std::uint32_t>(id, kHexBase);
    if (number && (*number & kErrorFlag) != 0) return LineKind::foreign;  // an error frame
  }
  return read_id(id, frame.frame) && read_packed(data, frame.frame) ? LineKind::frame
                                                                    : LineKind::broken;
}

/// Parses "123   [2]  00 11", after the interface.
LineKind read_people_format(std::string_view id, std::string_view rest, LoggedFrame& frame) {
  const std::string_view size = take_word(rest);
  if (size.size() == 4 && size.starts_with('[')) return LineKind::foreign;  // [64]: CAN FD
  if (size.size() != 3 || size.front() != '[' || size.back() != ']') return LineKind::broken;
  const auto count = parse_digits<std::uint8_t>(size.substr(1, 1));
  if (!count || *count > canopen::kMostData) return LineKind::broken;
  std::string_view peek = rest;
  const std::string_view word = take_word(peek);
  if (rest.find("ERRORFRAME") != std::string_view::npos) return LineKind::foreign;
  if (!read_id(id, frame.frame)) return LineKind::broken;
  if (word == "remote") {
    frame.frame.is_remote = true;
    frame.frame.size = *count;
    return LineKind::frame;
  }
  return read_bytes(rest, *count, kHexBase, frame.frame) ? LineKind::frame : LineKind::broken;
}

/// Skips the flags that candump -x puts between the interface and the identifier: "RX - -  ".
void skip_direction(std::string_view& text) {
  std::string_view rest = text;
  const std::string_view direction = take_word(rest);
  if (direction != "RX" && direction != "TX") return;
  for (int i = 0; i < 2; ++i) take_word(rest);
  text = rest;
}

LineKind read_candump(std::string_view line, LoggedFrame& frame) {
  skip_blanks(line);
  if (line.starts_with('(')) {
    const std::size_t end = line.find(')');
    if (end == std::string_view::npos) return LineKind::broken;
    std::string_view time = line.substr(1, end - 1);
    line.remove_prefix(end + 1);
    const std::string_view first = take_word(time);
    const std::string_view second = take_word(time);
    frame.time = second.empty() ? time_of(first) : time_of_day(first, second);
    if (!frame.time) return LineKind::broken;
  }
  frame.interface = take_word(line);
  skip_direction(line);
  const std::string_view id = take_word(line);
  if (frame.interface.empty() || id.empty()) return LineKind::broken;
  return id.find('#') == std::string_view::npos ? read_people_format(id, line, frame)
                                                : read_log_format(id, frame);
}

}  // namespace

LineKind LogLines::read(std::string_view line, LoggedFrame& frame) {
  frame = {};
  while (line.ends_with('\r') || line.ends_with(' ')) line.remove_suffix(1);
  std::string_view rest = line;
  skip_blanks(rest);
  if (rest.empty() || rest.starts_with('#') || rest.starts_with("//") || rest.starts_with(';')) {
    return LineKind::nothing;
  }
  if (read_asc_header(rest)) return LineKind::nothing;
  return is_asc_ ? read_asc(rest, frame) : read_candump(rest, frame);
}

bool LogLines::read_asc_header(std::string_view line) {
  std::string_view rest = line;
  const std::string_view word = take_word(rest);
  if (word == "base") {
    is_asc_ = true;
    is_asc_decimal_ = take_word(rest) == "dec";
    is_asc_relative_ = rest.find("relative") != std::string_view::npos;
    return true;
  }
  return word == "date" || word == "internal" || word == "no" || word == "Begin" || word == "End" ||
         word == "previous";
}

LineKind LogLines::read_asc(std::string_view line, LoggedFrame& frame) {
  std::string_view rest = line;
  const auto time = time_of(take_word(rest));
  if (!time) return LineKind::broken;
  const Time now = is_asc_relative_ ? asc_time_ + *time : *time;
  if (now > std::chrono::seconds(kLatestSecond + 1)) return LineKind::broken;
  frame.time = now;
  asc_time_ = now;
  frame.interface = take_word(rest);
  std::string_view id = take_word(rest);
  const std::string_view direction = take_word(rest);
  if (direction != "Rx" && direction != "Tx" && direction != "TxRq") return LineKind::foreign;
  const int base = is_asc_decimal_ ? 10 : kHexBase;
  frame.frame.is_extended = id.ends_with('x');
  if (frame.frame.is_extended) id.remove_suffix(1);
  const auto number = parse_digits<std::uint32_t>(id, base);
  const std::uint32_t highest =
      frame.frame.is_extended ? canopen::kHighestExtendedId : canopen::kHighestBaseId;
  if (!number) return LineKind::foreign;  // a named event of the logger
  if (*number > highest) return LineKind::broken;
  frame.frame.id = *number;
  const std::string_view kind = take_word(rest);
  if (kind == "r") {
    frame.frame.is_remote = true;
    return LineKind::frame;
  }
  const auto size = parse_digits<std::uint8_t>(take_word(rest), kHexBase);
  if (kind != "d" || !size || *size > canopen::kMostData) return LineKind::broken;
  return read_bytes(rest, *size, base, frame.frame) ? LineKind::frame : LineKind::broken;
}

}  // namespace vdrive::judge

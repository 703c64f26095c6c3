// SPDX-License-Identifier: Apache-2.0
#include "bus/socketcand.hpp"

#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>

namespace vdrive::canopen {
namespace {

constexpr std::string_view kSocketcandBlanks = " \t\r\n";
constexpr std::size_t kLongestBusName = 16;                  // limit of the protocol
constexpr std::size_t kExtendedDigits = 8;                   // of a 29-bit identifier
constexpr std::size_t kMostSocketcandWords = 3 + kMostData;  // send ID DLC BYTE...
// The daemon of linux-can checks its timer every 10 ms.
constexpr std::chrono::milliseconds kShortestStatistics{10};
constexpr std::chrono::milliseconds kLongestStatistics{std::chrono::hours(24)};

constexpr std::array<std::string_view, 7> kBroadcastManagerCommands{
    "add", "update", "delete", "subscribe", "unsubscribe", "filter", "muxfilter"};

void append_hex_byte(std::string& out, std::uint8_t byte) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  out += kDigits[byte >> 4U];
  out += kDigits[byte & 0xFU];
}

/// A frame to send, or why it is refused.
struct SendReading {
  std::optional<Frame> frame{};
  std::string_view problem{};
};

/// @param digits of an identifier
SendReading read_identifier(std::string_view digits) {
  const auto id = parse_digits<std::uint32_t>(digits, 16);
  if (!id || digits.size() > kExtendedDigits)
    return {.problem = "identifier is not 1 to 8 hexadecimal digits"};
  const bool is_extended = digits.size() == kExtendedDigits;
  if (*id > kHighestExtendedId) return {.problem = "identifier is above 1FFFFFFF"};
  if (!is_extended && *id > kHighestBaseId) {
    return {.problem = "identifier above 7FF needs eight digits"};
  }
  return {.frame = Frame{.id = *id, .is_extended = is_extended}};
}

SendReading read_size(SendReading reading, std::string_view digits) {
  const auto size = parse_digits<std::uint32_t>(digits);
  if (!size) return {.problem = "length is not a number"};
  if (*size > kMostData) return {.problem = "frame has more than 8 bytes"};
  if (reading.frame) reading.frame->size = static_cast<std::uint8_t>(*size);
  return reading;
}

}  // namespace

/// The parts of a word, which must outlive them.
struct SocketcandSession::Words {
  explicit Words(std::string_view text) {
    while (true) {
      const std::size_t start = text.find_first_not_of(kSocketcandBlanks);
      if (start == std::string_view::npos) return;
      text.remove_prefix(start);
      const std::size_t length = std::min(text.find_first_of(kSocketcandBlanks), text.size());
      if (count < kMostSocketcandWords) words.at(count) = text.substr(0, length);
      ++count;
      text.remove_prefix(length);
    }
  }

  /// @pre place < kMostSocketcandWords; empty after the last part
  [[nodiscard]] std::string_view at(std::size_t place) const { return words.at(place); }

  std::array<std::string_view, kMostSocketcandWords> words{};
  std::size_t count = 0;  ///< may exceed the number kept
};

void append_socketcand_frame(std::string& out, const Frame& frame, std::chrono::microseconds time) {
  constexpr std::int64_t kMicroseconds = 1'000'000;
  const std::int64_t since = std::max<std::int64_t>(time.count(), 0);
  std::array<char, 64> head{};  // at most 20 characters, 8 digits and two numbers of 64 bits
  const int length = std::snprintf(head.data(), head.size(), "\n< %s %0*X %lld.%06lld ",
                                   frame.is_remote ? "rtr" : "frame", frame.is_extended ? 8 : 3,
                                   frame.id, static_cast<long long>(since / kMicroseconds),
                                   static_cast<long long>(since % kMicroseconds));
  out.append(head.data(), static_cast<std::size_t>(length));
  if (frame.is_remote) out += std::to_string(frame.size);
  for (const std::uint8_t byte : frame.bytes()) append_hex_byte(out, byte);
  out += " >";
}

std::string socketcand_statistics(const SocketcandTraffic& traffic) {
  std::string text = "< stat";
  for (const std::uint64_t count :
       {traffic.received_bytes, traffic.received_frames, traffic.sent_bytes, traffic.sent_frames}) {
    text += ' ';
    text += std::to_string(count);
  }
  return text + " >";
}

void SocketcandSession::take(std::string_view bytes) {
  for (const char byte : bytes) {
    if (is_over_) return;
    take_byte(byte);
  }
}

void SocketcandSession::take_byte(char byte) {
  if (byte == '<') {
    // The end of the previous word was lost; this one may be complete.
    if (is_inside_) refuse("word has no end");
    is_inside_ = true;
    is_too_long_ = false;
    word_.clear();
  } else if (byte == '>') {
    if (std::exchange(is_inside_, false)) end_word();
  } else if (is_inside_) {
    is_too_long_ = is_too_long_ || word_.size() == kLongestSocketcandWord;
    if (!is_too_long_) word_ += byte;
  }
}

void SocketcandSession::end_word() {
  if (is_too_long_) return refuse("word is too long");
  const Words words(word_);
  if (words.count == 1 && words.at(0) == "echo") return host_.reply("< echo >");
  if (mode_ == SocketcandMode::no_bus) return open(words);
  if (words.count == 1 && change_mode(words.at(0))) return host_.reply("< ok >");
  take_command(words);
}

void SocketcandSession::take_command(const Words& words) {
  const std::string_view command = words.at(0);
  if (mode_ == SocketcandMode::control) return set_statistics(words);
  if (command == "send" || command == "sendrtr") return send(words);
  if (std::ranges::find(kBroadcastManagerCommands, command) != kBroadcastManagerCommands.end()) {
    return refuse("broadcast manager is not supported, use rawmode");
  }
  refuse("unknown command");
}

void SocketcandSession::open(const Words& words) {
  if (words.at(0) != "open") return refuse("open a bus first");
  const std::string_view name = words.at(1);
  const bool is_name =
      words.count == 2 && name.size() <= kLongestBusName && std::ranges::all_of(name, [](char c) {
        return c > ' ' && c <= '~';
      });
  if (!is_name) {
    is_over_ = true;
    return refuse("could not open bus");
  }
  mode_ = SocketcandMode::bcm;
  host_.reply("< ok >");
}

/// @return whether `command` is a mode of this server.
bool SocketcandSession::change_mode(std::string_view command) {
  if (command == "rawmode") {
    mode_ = SocketcandMode::raw;
  } else if (command == "bcmmode") {
    mode_ = SocketcandMode::bcm;
  } else if (command == "controlmode") {
    mode_ = SocketcandMode::control;
  } else {
    return false;
  }
  // The daemon of linux-can also ends statistics this way.
  if (mode_ != SocketcandMode::control) statistics_period_ = {};
  return true;
}

void SocketcandSession::send(const Words& words) {
  SendReading reading = read_identifier(words.at(1));
  if (reading.frame) reading = read_size(reading, words.at(2));
  if (!reading.frame) return refuse(reading.problem);
  Frame frame = *reading.frame;
  frame.is_remote = words.at(0) == "sendrtr";
  const std::size_t bytes = frame.bytes().size();
  constexpr std::size_t kBefore = 3;  // send ID DLC
  if (words.count != kBefore + bytes) return refuse("number of bytes is not the length");
  for (std::size_t i = 0; i < bytes; ++i) {
    // One digit is enough: python-can sends 0 to F this way.
    const auto byte = parse_digits<std::uint8_t>(words.at(kBefore + i), 16);
    if (!byte) return refuse("byte is not hexadecimal");
    frame.data.at(i) = *byte;
  }
  host_.send(frame);
}

void SocketcandSession::set_statistics(const Words& words) {
  if (words.at(0) != "statistics") return refuse("unknown command");
  const auto period = parse_digits<std::uint32_t>(words.at(1));
  if (words.count != 2 || !period) return refuse("statistics needs a number of milliseconds");
  const std::chrono::milliseconds wanted(*period);
  statistics_period_ = wanted == std::chrono::milliseconds::zero()
                           ? wanted
                           : std::clamp(wanted, kShortestStatistics, kLongestStatistics);
}

void SocketcandSession::refuse(std::string_view text) {
  ++refused_words_;
  host_.reply("< error " + std::string(text) + " >");
}

}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "vdrive/number_text.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::canopen {

/// @param text in the notation of can-utils: "601#4041600000000000", "181#R", "00000601#00"
///         (extended)
/// @throws std::bad_optional_access if a digit is not hexadecimal.
inline Frame frame_of(std::string_view text) {
  constexpr std::size_t kBaseDigits = 3;
  const std::size_t mark = text.find('#');
  Frame frame;
  frame.id = parse_digits<std::uint32_t>(text.substr(0, mark), 16).value();
  frame.is_extended = mark > kBaseDigits;
  std::string_view data = text.substr(mark + 1);
  if (data == "R") {
    frame.is_remote = true;
    return frame;
  }
  for (; !data.empty(); data.remove_prefix(2)) {
    frame.data.at(frame.size) = parse_digits<std::uint8_t>(data.substr(0, 2), 16).value();
    ++frame.size;
  }
  return frame;
}

inline std::string hex_digits(std::uint32_t number, std::size_t count) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string text(count, '0');
  for (std::size_t i = count; i-- > 0; number >>= 4U) text[i] = kDigits[number & 0xFU];
  return text;
}

/// @return the frame in the notation that frame_of() reads.
inline std::string text_of(const Frame& frame) {
  std::string text = hex_digits(frame.id, frame.is_extended ? 8 : 3) + '#';
  if (frame.is_remote) return text + 'R';
  for (const std::uint8_t byte : frame.bytes()) text += hex_digits(byte, 2);
  return text;
}

inline std::ostream& operator<<(std::ostream& stream, const Frame& frame) {
  return stream << text_of(frame);
}

/// A host that records the actions of a node and answers nothing on its own.
class FakeHost final : public NodeHost {
 public:
  void send(const Frame& frame) override { frames.push_back(frame); }

  void begin_access(const DriveAccess& access) override { accesses.push_back(access); }

  void command(std::span<const DriveValue> values) override {
    commands.emplace_back(values.begin(), values.end());
  }

  void set_connection_lost(bool is_lost) override { connection_lost.push_back(is_lost); }

  void power_cycle() override { ++power_cycles; }

  bool store(const std::map<ObjectAddress, std::uint32_t>& parameters) override {
    if (can_store) stored.push_back(parameters);
    return can_store;
  }

  /// @return the frames since the previous call, as text.
  std::vector<std::string> take() {
    std::vector<std::string> texts;
    for (const Frame& frame : std::exchange(frames, {})) texts.push_back(text_of(frame));
    return texts;
  }

  std::vector<Frame> frames;
  std::vector<DriveAccess> accesses;
  std::vector<std::vector<DriveValue>> commands;
  std::deque<bool> connection_lost;
  int power_cycles = 0;
  std::vector<std::map<ObjectAddress, std::uint32_t>> stored;
  bool can_store = true;
};

}  // namespace vdrive::canopen

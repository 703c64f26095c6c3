// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/bus.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::canopen {

using Frames = std::vector<Frame>;

/// A port that records the frames it receives.
class RecordedPort final : public Port {
 public:
  explicit RecordedPort(Bus& bus) : bus_(bus) { bus_.attach(*this); }

  ~RecordedPort() override { bus_.detach(*this); }

  RecordedPort(const RecordedPort&) = delete;
  RecordedPort& operator=(const RecordedPort&) = delete;

  void deliver(const Frame& frame) override { frames.push_back(frame); }

  void send(const Frame& frame) { bus_.send(frame, this); }

  Frames frames;

 private:
  Bus& bus_;
};

/// A bus host that records its calls. Nodes 1 to 3 can be disturbed.
struct RecordedHost final : BusHost {
  void report(bridge::Severity /*severity*/, const std::string& /*port*/,
              const std::string& text) override {
    reports.push_back(text);
  }

  [[nodiscard]] std::chrono::microseconds frame_time() const override { return time; }

  [[nodiscard]] std::optional<std::string> disturb(std::uint8_t node,
                                                   std::string_view /*fault*/) override {
    constexpr std::uint8_t kHighest = 3;
    if (node <= kHighest) return std::nullopt;
    return "no node " + std::to_string(node);
  }

  std::vector<std::string> reports;
  std::chrono::microseconds time{};
};

/// @return a data frame in the base format.
inline Frame data_frame(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  Frame frame{.id = id, .size = static_cast<std::uint8_t>(bytes.size())};
  std::size_t place = 0;
  for (const std::uint8_t byte : bytes) frame.data.at(place++) = byte;
  return frame;
}

}  // namespace vdrive::canopen

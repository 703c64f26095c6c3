// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive/wire/presence_by_age.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>
#include <string_view>
#include <vector>

namespace vdrive::client {

inline constexpr Directory::Clock::time_point kStart{};
inline constexpr wire::Source kSource{{1, 2, 3}};

/// A presence without any participants: benches are judged by the age of their samples.
inline const wire::Presence& by_age() {
  static const wire::PresenceByAge presence([](std::string_view /*beginning*/) {
    return std::vector<wire::OtherParticipant>();
  });
  return presence;
}

inline msg::BenchDescription description(std::uint32_t bench, std::uint64_t incarnation,
                                         std::uint16_t part = 0, std::uint16_t parts = 1) {
  msg::BenchDescription message;
  message.bench = bench;
  message.incarnation = incarnation;
  message.part = part;
  message.parts = parts;
  message.alive = true;
  message.clock_mode = msg::ClockMode::lockstep;
  message.period_us = 1000;
  message.status_every_ticks = 1;
  msg::AxisDescription axis;
  axis.axis = static_cast<std::uint16_t>(part + 1);
  axis.name = "axis";
  message.axes.push_back(axis);
  return message;
}

inline msg::BenchState state(std::uint32_t bench, std::uint64_t incarnation,
                             std::uint64_t tick = 0) {
  msg::BenchState message;
  message.bench = bench;
  message.incarnation = incarnation;
  message.tick = tick;
  message.rate = 1.0;
  return message;
}

}  // namespace vdrive::client

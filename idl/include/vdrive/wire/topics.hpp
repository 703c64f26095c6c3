// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive_messages.h"

#include <string_view>

namespace vdrive::wire {

/// Topics of the wire contract, version 1. A topic's message type names it:
/// CommandFrame, CommandReply, Request, Reply, StatusFrame, AxisStatus, AxisParameters, Event,
/// BenchDescription, BenchState.
inline constexpr std::string_view kTopicPrefix = "vdrive/v1/";

template <typename Message>
struct Topic;  // name of the topic without the prefix

template <>
struct Topic<msg::CommandFrame> {
  static constexpr std::string_view kName = "command";
};

template <>
struct Topic<msg::CommandReply> {
  static constexpr std::string_view kName = "command_reply";
};

template <>
struct Topic<msg::Request> {
  static constexpr std::string_view kName = "request";
};

template <>
struct Topic<msg::Reply> {
  static constexpr std::string_view kName = "reply";
};

template <>
struct Topic<msg::StatusFrame> {
  static constexpr std::string_view kName = "status";
};

template <>
struct Topic<msg::AxisStatus> {
  static constexpr std::string_view kName = "axis";
};

template <>
struct Topic<msg::AxisParameters> {
  static constexpr std::string_view kName = "parameters";
};

template <>
struct Topic<msg::Event> {
  static constexpr std::string_view kName = "event";
};

template <>
struct Topic<msg::BenchDescription> {
  static constexpr std::string_view kName = "bench";
};

template <>
struct Topic<msg::BenchState> {
  static constexpr std::string_view kName = "bench_state";
};

}  // namespace vdrive::wire

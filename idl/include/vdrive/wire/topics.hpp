// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive_messages.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace vdrive::wire {

/// Topics of the wire contract, version 1, are called "vdrive/v1/" and their name.
inline constexpr std::string_view kTopicPrefix = "vdrive/v1/";

/// The topics, in the order of `kTopics`.
enum class TopicId : std::uint8_t {
  command,
  command_reply,
  request,
  reply,
  status,
  axis,
  parameters,
  event,
  bench,
  bench_state,
};

/// The members that are the key of a topic. They are the first ones of its message.
enum class TopicKey : std::uint8_t {
  none,
  bench,             ///< uint32
  bench_and_number,  ///< uint32, uint16: an axis, or a part of a description
};

/// What both sides of a topic need to know. Every list of topics in the code reads this table.
struct TopicTraits {
  std::string_view name;       ///< without the prefix
  std::string_view type_name;  ///< as it is announced
  TopicKey key = TopicKey::none;
  std::size_t bench_offset = 0;  ///< of the number of the bench, behind the encapsulation [bytes]
  bool reliable = false;
  bool transient_local = false;
  bool keep_all = false;  ///< of readers; and of writers unless `writer_keeps_newest`
  /// The writer drops samples that a reader does not fetch in favour of newer ones: one writer
  /// sends the replies to many clients, and a client that hangs must not block the replies to the
  /// others.
  bool writer_keeps_newest = false;
  std::int32_t depth = 1;      ///< samples kept of an instance
  std::int32_t instances = 1;  ///< keys in the whole domain
};

inline constexpr std::int32_t kAxesInDomain = 65'536;
inline constexpr std::int32_t kBenchesInDomain = 1'024;
inline constexpr std::int32_t kBenchPartsInDomain = 4'096;
inline constexpr std::int32_t kQueueDepth = 1'024;

inline constexpr std::array<TopicTraits, 10> kTopics{{
    {.name = "command",
     .type_name = "vdrive::msg::CommandFrame",
     .reliable = true,
     .keep_all = true,
     .depth = kQueueDepth},
    {.name = "command_reply",
     .type_name = "vdrive::msg::CommandReply",
     .reliable = true,
     .keep_all = true,
     .writer_keeps_newest = true,
     .depth = kQueueDepth},
    {.name = "request",
     .type_name = "vdrive::msg::Request",
     .bench_offset = 16,  // behind client and request_id
     .reliable = true,
     .keep_all = true,
     .depth = kQueueDepth},
    {.name = "reply",
     .type_name = "vdrive::msg::Reply",
     .bench_offset = 16,
     .reliable = true,
     .keep_all = true,
     .writer_keeps_newest = true,
     .depth = kQueueDepth},
    {.name = "status", .type_name = "vdrive::msg::StatusFrame", .depth = 64},
    {.name = "axis",
     .type_name = "vdrive::msg::AxisStatus",
     .key = TopicKey::bench_and_number,
     .instances = kAxesInDomain},
    {.name = "parameters",
     .type_name = "vdrive::msg::AxisParameters",
     .key = TopicKey::bench_and_number,
     .reliable = true,
     .transient_local = true,
     .instances = kAxesInDomain},
    {.name = "event",
     .type_name = "vdrive::msg::Event",
     .key = TopicKey::bench,
     .reliable = true,
     .transient_local = true,
     .depth = 1'024,
     .instances = kBenchesInDomain},
    {.name = "bench",
     .type_name = "vdrive::msg::BenchDescription",
     .key = TopicKey::bench_and_number,
     .reliable = true,
     .transient_local = true,
     .instances = kBenchPartsInDomain},
    {.name = "bench_state",
     .type_name = "vdrive::msg::BenchState",
     .key = TopicKey::bench,
     .instances = kBenchesInDomain},
}};

[[nodiscard]] constexpr const TopicTraits& traits_of(TopicId topic) noexcept {
  return kTopics[static_cast<std::size_t>(topic)];
}

/// @return the topic of that number, or nothing: for numbers that another process wrote.
[[nodiscard]] constexpr std::optional<TopicId> topic_numbered(std::size_t number) noexcept {
  return number < kTopics.size() ? std::optional(static_cast<TopicId>(number)) : std::nullopt;
}

/// The topic of a message type: its number and its name without the prefix.
template <typename Message>
struct Topic;

template <TopicId kTopic>
struct NumberedTopic {
  static constexpr TopicId kId = kTopic;
  static constexpr std::string_view kName = traits_of(kTopic).name;
};

template <>
struct Topic<msg::CommandFrame> : NumberedTopic<TopicId::command> {};

template <>
struct Topic<msg::CommandReply> : NumberedTopic<TopicId::command_reply> {};

template <>
struct Topic<msg::Request> : NumberedTopic<TopicId::request> {};

template <>
struct Topic<msg::Reply> : NumberedTopic<TopicId::reply> {};

template <>
struct Topic<msg::StatusFrame> : NumberedTopic<TopicId::status> {};

template <>
struct Topic<msg::AxisStatus> : NumberedTopic<TopicId::axis> {};

template <>
struct Topic<msg::AxisParameters> : NumberedTopic<TopicId::parameters> {};

template <>
struct Topic<msg::Event> : NumberedTopic<TopicId::event> {};

template <>
struct Topic<msg::BenchDescription> : NumberedTopic<TopicId::bench> {};

template <>
struct Topic<msg::BenchState> : NumberedTopic<TopicId::bench_state> {};

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/cdr.hpp"
#include "vdrive_messages_description.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace vdrive::wire {

/// Prefix of the names of all topics of version 1 of the wire contract.
inline constexpr std::string_view kTopicPrefix = "vdrive/v1/";

/// How the samples of a topic are sent and kept.
struct TopicQuality {
  bool reliable = false;
  bool transient_local = false;
  bool keep_all = false;  ///< for readers, and for writers unless `writer_keeps_newest`
  /// The writer drops samples that a reader has not fetched, to make room for newer ones. One
  /// writer sends the replies to many clients, and a client that hangs must not block the replies
  /// to the others.
  bool writer_keeps_newest = false;
  std::int32_t depth = 1;      ///< samples kept per instance
  std::int32_t instances = 1;  ///< number of keys in the domain
};

/// The side that publishes a topic; the other one subscribes.
enum class Publisher : std::uint8_t { client, service };

/// A topic: the type of its messages, its name without the prefix, its publisher and its quality.
template <typename Message>
struct TopicRow {
  std::string_view name;
  Publisher publisher = Publisher::service;
  TopicQuality quality{};
};

inline constexpr std::int32_t kAxesInDomain = 65'536;
inline constexpr std::int32_t kBenchesInDomain = 1'024;
inline constexpr std::int32_t kBenchPartsInDomain = 4'096;
inline constexpr std::int32_t kSessionsInDomain = 65'536;
inline constexpr std::int32_t kSessionsOfBench = 256;  // instances of `bench_session` per bench
inline constexpr std::int32_t kQueueDepth = 1'024;

/// The topics. To add one, add a struct to the IDL and a row here: its number, codec, key, type
/// support, QoS, publication and subscription are derived from these.
inline constexpr std::tuple kTopicRows{
    TopicRow<msg::CommandFrame>{
        "command", Publisher::client, {.reliable = true, .keep_all = true, .depth = kQueueDepth}},
    TopicRow<msg::CommandReply>{
        "command_reply",
        Publisher::service,
        {.reliable = true, .keep_all = true, .writer_keeps_newest = true, .depth = kQueueDepth}},
    TopicRow<msg::Request>{
        "request", Publisher::client, {.reliable = true, .keep_all = true, .depth = kQueueDepth}},
    TopicRow<msg::Reply>{
        "reply",
        Publisher::service,
        {.reliable = true, .keep_all = true, .writer_keeps_newest = true, .depth = kQueueDepth}},
    TopicRow<msg::StatusFrame>{"status", Publisher::service, {.depth = 64}},
    TopicRow<msg::AxisStatus>{"axis", Publisher::service, {.instances = kAxesInDomain}},
    TopicRow<msg::AxisParameters>{
        "parameters",
        Publisher::service,
        {.reliable = true, .transient_local = true, .instances = kAxesInDomain}},
    TopicRow<msg::Event>{
        "event",
        Publisher::service,
        {.reliable = true, .transient_local = true, .depth = 1'024, .instances = kBenchesInDomain}},
    TopicRow<msg::BenchDescription>{
        "bench",
        Publisher::service,
        {.reliable = true, .transient_local = true, .instances = kBenchPartsInDomain}},
    TopicRow<msg::BenchState>{"bench_state", Publisher::service, {.instances = kBenchesInDomain}},
    TopicRow<msg::SessionName>{
        "session",
        Publisher::client,
        {.reliable = true, .transient_local = true, .instances = kSessionsInDomain}},
    TopicRow<msg::BenchSession>{"bench_session",
                                Publisher::service,
                                {.reliable = true,
                                 .transient_local = true,
                                 .instances = kBenchesInDomain * kSessionsOfBench}},
};

/// The number of a topic: the position of its row. `Topic<Message>::kId` is the one for a message,
/// such as `Topic<msg::StatusFrame>::kId`.
enum class TopicId : std::uint8_t {};

/// The properties of a topic that can be looked up by its number.
struct TopicTraits : TopicQuality {
  std::string_view name;  ///< without the prefix
  Publisher publisher{};
  std::string_view type_name;  ///< as announced
  bool has_key = false;
  std::size_t bench_offset = 0;  ///< position of the bench number in a sample [bytes]
};

namespace detail {

template <typename Message>
constexpr TopicTraits traits_of_row(const TopicRow<Message>& row) {
  TopicTraits traits;
  static_cast<TopicQuality&>(traits) = row.quality;
  traits.name = row.name;
  traits.publisher = row.publisher;
  traits.type_name = Description<Message>::kName;
  traits.bench_offset = kEncapsulation + place_of_member<Message>("bench");
  for_each_member<Message>([&traits](const MemberTraits& member) {
    traits.has_key = traits.has_key || member.is_key;
  });
  return traits;
}

}  // namespace detail

/// The traits of all topics, by number.
inline constexpr std::array kTopics = std::apply(
    [](const auto&... rows) {
      return std::array{detail::traits_of_row(rows)...};
    },
    kTopicRows);

[[nodiscard]] constexpr const TopicTraits& traits_of(TopicId topic) noexcept {
  return kTopics[static_cast<std::size_t>(topic)];
}

/// @return the topic with that number, or nothing; for numbers received from another process.
[[nodiscard]] constexpr std::optional<TopicId> topic_numbered(std::size_t number) noexcept {
  return number < kTopics.size() ? std::optional(static_cast<TopicId>(number)) : std::nullopt;
}

/// The topic of a message type, found at compile time. A type without a row does not compile.
template <typename Message>
struct Topic {
  static constexpr const TopicRow<Message>& kRow = std::get<TopicRow<Message>>(kTopicRows);
  static constexpr TopicId kId = std::apply(
      [](const auto&... rows) {
        std::size_t number = 0;
        // Counts the rows before the one of the message.
        static_cast<void>(
            ((!std::is_same_v<std::remove_cvref_t<decltype(rows)>, TopicRow<Message>> &&
              ++number != 0) &&
             ...));
        return static_cast<TopicId>(number);
      },
      kTopicRows);
  static constexpr std::string_view kName = kRow.name;
};

}  // namespace vdrive::wire

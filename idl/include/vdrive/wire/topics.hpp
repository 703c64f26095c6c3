// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive_messages.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace vdrive::wire {

/// Topics of the wire contract, version 1, are called "vdrive/v1/" and their name.
inline constexpr std::string_view kTopicPrefix = "vdrive/v1/";

/// The members that are the key of a topic. They are the first ones of its message.
enum class TopicKey : std::uint8_t {
  none,
  bench,              ///< uint32
  bench_and_number,   ///< uint32, uint16: an axis, a part of a description, a place
  bench_and_session,  ///< uint32, uint64
};

/// What both sides of a topic need to know, whatever its messages are.
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

/// Everything about a topic: the type of its messages, its traits, the bounds of its sequences.
template <typename Message>
struct TopicRow {
  TopicTraits traits;

  /// The generated code takes sequences of any length; strings it cuts.
  /// @return whether every sequence of a message is within the bound of the IDL.
  bool (*within_bounds)(const Message& message) noexcept = [](const Message&) noexcept {
    return true;  // a message without sequences
  };
};

inline constexpr std::int32_t kAxesInDomain = 65'536;
inline constexpr std::int32_t kBenchesInDomain = 1'024;
inline constexpr std::int32_t kBenchPartsInDomain = 4'096;
inline constexpr std::int32_t kSessionsInDomain = 65'536;
inline constexpr std::int32_t kSessionsOfBench = 256;  // places of `bench_session`
inline constexpr std::int32_t kQueueDepth = 1'024;
inline constexpr std::size_t kLatenessBins = 32;

/// The topics. A new one is a struct of the IDL and a row here: its number, codec, type support,
/// QoS, publication and subscription follow from the row.
inline constexpr std::tuple kTopicRows{
    TopicRow<msg::CommandFrame>{
        .traits = {.name = "command",
                   .type_name = "vdrive::msg::CommandFrame",
                   .reliable = true,
                   .keep_all = true,
                   .depth = kQueueDepth},
        .within_bounds =
            [](const msg::CommandFrame& message) noexcept {
              return message.axes().size() <= msg::MAX_AXES_PER_FRAME &&
                     std::ranges::all_of(message.axes(), [](const msg::AxisCommand& axis) {
                       return axis.objects().size() <= msg::MAX_OBJECTS_PER_AXIS;
                     });
            }},
    TopicRow<msg::CommandReply>{.traits = {.name = "command_reply",
                                           .type_name = "vdrive::msg::CommandReply",
                                           .reliable = true,
                                           .keep_all = true,
                                           .writer_keeps_newest = true,
                                           .depth = kQueueDepth},
                                .within_bounds =
                                    [](const msg::CommandReply& message) noexcept {
                                      return message.refusals().size() <= msg::MAX_AXES_PER_FRAME &&
                                             message.ignored_set_points().size() <=
                                                 msg::MAX_AXES_PER_FRAME;
                                    }},
    TopicRow<msg::Request>{.traits = {.name = "request",
                                      .type_name = "vdrive::msg::Request",
                                      .bench_offset = 16,  // behind client and request_id
                                      .reliable = true,
                                      .keep_all = true,
                                      .depth = kQueueDepth},
                           .within_bounds =
                               [](const msg::Request& message) noexcept {
                                 return message.axes().size() <= msg::MAX_AXES_PER_FRAME &&
                                        message.objects().size() <= msg::MAX_OBJECTS_PER_REQUEST;
                               }},
    TopicRow<msg::Reply>{.traits = {.name = "reply",
                                    .type_name = "vdrive::msg::Reply",
                                    .bench_offset = 16,
                                    .reliable = true,
                                    .keep_all = true,
                                    .writer_keeps_newest = true,
                                    .depth = kQueueDepth},
                         .within_bounds =
                             [](const msg::Reply& message) noexcept {
                               return message.objects().size() <= msg::MAX_OBJECTS_PER_REQUEST &&
                                      message.statuses().size() <= msg::MAX_AXES_PER_FRAME;
                             }},
    TopicRow<msg::StatusFrame>{
        .traits = {.name = "status", .type_name = "vdrive::msg::StatusFrame", .depth = 64},
        .within_bounds =
            [](const msg::StatusFrame& message) noexcept {
              return message.axes().size() <= msg::MAX_AXES_PER_FRAME;
            }},
    TopicRow<msg::AxisStatus>{.traits = {.name = "axis",
                                         .type_name = "vdrive::msg::AxisStatus",
                                         .key = TopicKey::bench_and_number,
                                         .instances = kAxesInDomain}},
    TopicRow<msg::AxisParameters>{.traits = {.name = "parameters",
                                             .type_name = "vdrive::msg::AxisParameters",
                                             .key = TopicKey::bench_and_number,
                                             .reliable = true,
                                             .transient_local = true,
                                             .instances = kAxesInDomain}},
    TopicRow<msg::Event>{.traits = {.name = "event",
                                    .type_name = "vdrive::msg::Event",
                                    .key = TopicKey::bench,
                                    .reliable = true,
                                    .transient_local = true,
                                    .depth = 1'024,
                                    .instances = kBenchesInDomain}},
    TopicRow<msg::BenchDescription>{.traits = {.name = "bench",
                                               .type_name = "vdrive::msg::BenchDescription",
                                               .key = TopicKey::bench_and_number,
                                               .reliable = true,
                                               .transient_local = true,
                                               .instances = kBenchPartsInDomain},
                                    .within_bounds =
                                        [](const msg::BenchDescription& message) noexcept {
                                          return message.axes().size() <= msg::MAX_AXES_PER_FRAME;
                                        }},
    TopicRow<msg::BenchState>{.traits = {.name = "bench_state",
                                         .type_name = "vdrive::msg::BenchState",
                                         .key = TopicKey::bench,
                                         .instances = kBenchesInDomain},
                              .within_bounds =
                                  [](const msg::BenchState& message) noexcept {
                                    return message.lateness_histogram().size() <= kLatenessBins;
                                  }},
    TopicRow<msg::SessionName>{.traits = {.name = "session",
                                          .type_name = "vdrive::msg::SessionName",
                                          .key = TopicKey::bench_and_session,
                                          .reliable = true,
                                          .transient_local = true,
                                          .instances = kSessionsInDomain}},
    TopicRow<msg::BenchSession>{.traits = {.name = "bench_session",
                                           .type_name = "vdrive::msg::BenchSession",
                                           .key = TopicKey::bench_and_number,
                                           .reliable = true,
                                           .transient_local = true,
                                           .instances = kBenchesInDomain * kSessionsOfBench}},
};

/// The number of a topic: the place of its row. `Topic<msg::StatusFrame>::kId` is that of a
/// message.
enum class TopicId : std::uint8_t {};

/// The traits of all topics, by their number.
inline constexpr std::array kTopics = std::apply(
    [](const auto&... rows) {
      return std::array{rows.traits...};
    },
    kTopicRows);

[[nodiscard]] constexpr const TopicTraits& traits_of(TopicId topic) noexcept {
  return kTopics[static_cast<std::size_t>(topic)];
}

/// @return the topic of that number, or nothing: for numbers that another process wrote.
[[nodiscard]] constexpr std::optional<TopicId> topic_numbered(std::size_t number) noexcept {
  return number < kTopics.size() ? std::optional(static_cast<TopicId>(number)) : std::nullopt;
}

/// The topic of a message type, found at compile time; a type without a row does not compile.
template <typename Message>
struct Topic {
  static constexpr const TopicRow<Message>& kRow = std::get<TopicRow<Message>>(kTopicRows);
  static constexpr TopicId kId = std::apply(
      [](const auto&... rows) {
        std::size_t number = 0;
        // Counts the rows before that of the message.
        static_cast<void>(
            ((!std::is_same_v<std::remove_cvref_t<decltype(rows)>, TopicRow<Message>> &&
              ++number != 0) &&
             ...));
        return static_cast<TopicId>(number);
      },
      kTopicRows);
  static constexpr std::string_view kName = kRow.traits.name;
};

}  // namespace vdrive::wire

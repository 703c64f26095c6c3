// SPDX-License-Identifier: Apache-2.0
// The rows of the topics, compared with everything that repeats them.
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/topics.hpp"

#include <gtest/gtest.h>

#include <cxxabi.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <typeinfo>
#include <vector>

namespace vdrive::wire {
namespace {

using Names = std::set<std::string>;

template <typename Visit>
void for_each_row(const Visit& visit) {
  std::apply(
      [&visit](const auto&... rows) {
        (visit(rows), ...);
      },
      kTopicRows);
}

TEST(TopicRows, HaveTheNumberThatTheirMessageGives) {
  for_each_row([]<typename Message>(const TopicRow<Message>& row) {
    EXPECT_EQ(traits_of(Topic<Message>::kId).name, row.name);
    EXPECT_EQ(topic_numbered(static_cast<std::size_t>(Topic<Message>::kId)), Topic<Message>::kId);
  });
  EXPECT_EQ(topic_numbered(kTopics.size()), std::nullopt);
}

TEST(TopicRows, HaveUniqueNames) {
  Names names;
  for (const TopicTraits& topic : kTopics) names.emplace(topic.name);
  EXPECT_EQ(names.size(), kTopics.size());
}

// A topic of version 1 keeps its name and type. More topics may be added, each of them optional.
TEST(TopicRows, HaveThoseOf1_0WithTheirTypes) {
  const std::map<std::string, std::string> kept{{"axis", "AxisStatus"},
                                                {"bench", "BenchDescription"},
                                                {"bench_session", "BenchSession"},
                                                {"bench_state", "BenchState"},
                                                {"command", "CommandFrame"},
                                                {"command_reply", "CommandReply"},
                                                {"event", "Event"},
                                                {"parameters", "AxisParameters"},
                                                {"reply", "Reply"},
                                                {"request", "Request"},
                                                {"session", "SessionName"},
                                                {"status", "StatusFrame"}};
  EXPECT_EQ(kTopicPrefix, "vdrive/v1/");
  std::map<std::string, std::string> now;
  for (const TopicTraits& topic : kTopics) now.emplace(topic.name, topic.type_name);
  for (const auto& [name, type] : kept) EXPECT_EQ(now[name], "vdrive::msg::" + type) << name;
}

std::string name_of_type(const std::type_info& type) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(type.name(), nullptr, nullptr, &status), &std::free);
  return status == 0 ? name.get() : type.name();
}

TEST(TopicRows, AnnounceTheTypeOfTheirMessage) {
  for_each_row([]<typename Message>(const TopicRow<Message>& /*row*/) {
    EXPECT_EQ(traits_of(Topic<Message>::kId).type_name, name_of_type(typeid(Message)));
  });
}

TEST(TopicRows, HaveTheirBenchWhereTheSampleHasIt) {
  for_each_row([]<typename Message>(const TopicRow<Message>& row) {
    Message message;
    message.bench = 0x12345678;
    std::vector<std::byte> sample(encoded_size(message));
    ASSERT_EQ(encode(message, sample), sample.size());
    std::uint32_t bench = 0;
    std::memcpy(&bench, &sample.at(traits_of(Topic<Message>::kId).bench_offset), sizeof bench);
    EXPECT_EQ(bench, message.bench) << row.name;
  });
}

/// make_member.sh uses this list to give each role its topics; tests/security has members of each
/// role.
TEST(Permissions, NameEveryTopicWithThePublisherOfItsRow) {
  std::map<std::string, std::string> rows;
  for (const TopicTraits& topic : kTopics) {
    rows[std::string(topic.name)] = topic.publisher == Publisher::client ? "client" : "service";
  }
  std::map<std::string, std::string> listed;
  std::ifstream file(VDRIVE_SOURCE_DIR "/deploy/security/topics.txt");
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string topic;
    std::string publisher;
    if (words >> topic >> publisher && topic != "#") listed[topic] = publisher;
  }
  EXPECT_EQ(listed, rows);
}

}  // namespace
}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
// What stands beside the rows of the topics, compared with them.
#include "vdrive/wire/topics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cxxabi.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <typeinfo>

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
    EXPECT_EQ(traits_of(Topic<Message>::kId).name, row.traits.name);
    EXPECT_EQ(topic_numbered(static_cast<std::size_t>(Topic<Message>::kId)), Topic<Message>::kId);
  });
  EXPECT_EQ(topic_numbered(kTopics.size()), std::nullopt);
}

TEST(TopicRows, HaveNamesOfTheirOwn) {
  Names names;
  for (const TopicTraits& topic : kTopics) names.emplace(topic.name);
  EXPECT_EQ(names.size(), kTopics.size());
}

std::string name_of_type(const std::type_info& type) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(type.name(), nullptr, nullptr, &status), &std::free);
  return status == 0 ? name.get() : type.name();
}

TEST(TopicRows, AnnounceTheTypeOfTheirMessage) {
  for_each_row([]<typename Message>(const TopicRow<Message>& row) {
    EXPECT_EQ(row.traits.type_name, name_of_type(typeid(Message)));
  });
}

TEST(TopicRows, HaveTheKeyOfTheIdl) {
  for_each_row([]<typename Message>(const TopicRow<Message>& row) {
    EXPECT_EQ(row.traits.key != TopicKey::none, Message::isKeyDefined()) << row.traits.name;
    // uint32, or uint32 and uint16, or uint32 and uint64, which begins at 8; the generator counts
    // each key as if it stood alone.
    const std::size_t size = row.traits.key == TopicKey::bench               ? 4
                             : row.traits.key == TopicKey::bench_and_number  ? 6
                             : row.traits.key == TopicKey::bench_and_session ? 16
                                                                             : 0;
    EXPECT_EQ(Message::getKeyMaxCdrSerializedSize(), size) << row.traits.name;
  });
}

/// @return the topics that the permissions of a role name between <action> and </action>, without
///         the prefix.
Names named(const std::string& role, const std::string& action) {
  std::ifstream file(VDRIVE_SOURCE_DIR "/deploy/security/permissions_" + role + ".xml");
  std::ostringstream content;
  content << file.rdbuf();
  const std::string text = content.str();
  const std::size_t first = text.find("<" + action + ">");
  if (first == std::string::npos) return {};
  const std::string part = text.substr(first, text.find("</" + action + ">") - first);
  const std::regex topic("<topic>" + std::string(kTopicPrefix) + "(.*)</topic>");
  Names names;
  for (std::sregex_iterator match(part.begin(), part.end(), topic), end; match != end; ++match) {
    names.insert((*match)[1]);
  }
  return names;
}

Names all_of(const Names& some, const Names& others) {
  Names names = some;
  names.insert(others.begin(), others.end());
  return names;
}

TEST(Permissions, NameEveryTopicOnBothSides) {
  Names topics;
  for (const TopicTraits& topic : kTopics) topics.emplace(topic.name);
  const Names commands = named("controller", "publish");
  const Names reports = named("service", "publish");
  EXPECT_EQ(all_of(commands, reports), topics) << "no role publishes the others";
  EXPECT_EQ(commands.size() + reports.size(), topics.size()) << "two roles publish one topic";
  // A service also reads bench_state: it shows another service with the number of its bench.
  EXPECT_EQ(named("service", "subscribe"), all_of(commands, {"bench_state"}));
  EXPECT_EQ(named("controller", "subscribe"), reports);
  EXPECT_EQ(named("viewer", "subscribe"), reports);
  EXPECT_THAT(named("viewer", "publish"), testing::IsEmpty());
}

}  // namespace
}  // namespace vdrive::wire

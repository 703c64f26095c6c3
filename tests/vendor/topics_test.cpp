// SPDX-License-Identifier: Apache-2.0
// Every topic of the network interface between Fast DDS, as used by service and clients, and
// Cyclone DDS, in both directions, compared field by field.
#include "vdrive/wire/topics.hpp"

#include "support/test_domain.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vendor/fast_messages.hpp"
#include "vendor/peer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <iterator>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds kPatience = 40s;

template <typename Message>
std::string full_name() {
  return std::string(wire::kTopicPrefix) + std::string(wire::Topic<Message>::kName);
}

template <typename Message>
Message filled(int filling, std::uint64_t instance = 0, std::uint64_t count = 0) {
  Filler filler{static_cast<Filling>(filling), instance, count};
  Message message;
  fill(message, filler);
  return message;
}

template <typename Message>
constexpr bool kIsStream =
    wire::Topic<Message>::kName == "status" || wire::Topic<Message>::kName == "axis" ||
    wire::Topic<Message>::kName == "bench_state";

/// The texts of the samples that our reader received; marked if their bytes are not those that we
/// would write.
template <typename Message>
class Texts {
 public:
  explicit Texts(wire::Participant& participant)
      : reader_(participant.make_reader(wire::Topic<Message>::kId,
                                        {.take =
                                             [this](std::span<const std::byte> sample) {
                                               keep(text_in(sample));
                                             },
                                         .deliver = [](const wire::Source& /*source*/) {}})) {}

  [[nodiscard]] bool match() { return reader_->matches().wait_for(1, kPatience); }

  /// @return the oldest text not yet taken; empty if none arrives.
  std::string take(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    const bool found = changed_.wait_for(lock, patience, [&] {
      return !texts_.empty();
    });
    std::string text;
    if (found) {
      text = std::move(texts_.front());
      texts_.pop_front();
    }
    return text;
  }

 private:
  /// The library pads samples to a multiple of 4 bytes.
  static std::string text_in(std::span<const std::byte> sample) {
    Message message;
    if (!wire::decode(sample, message)) return "cannot be read";
    std::vector<std::byte> ours(wire::encoded_size(message));
    wire::encode(message, ours);
    const bool are_same =
        sample.size() >= ours.size() && sample.size() < ours.size() + 4 &&
        std::ranges::equal(std::span(ours).subspan(wire::kEncapsulation),
                           sample.first(ours.size()).subspan(wire::kEncapsulation));
    return (are_same ? "" : "other bytes: ") + text_of(message);
  }

  void keep(std::string text) {
    const std::lock_guard lock(mutex_);
    texts_.push_back(std::move(text));
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> texts_;
  std::unique_ptr<wire::SampleReader> reader_;
};

/// Calls `send`, repeatedly if samples may be lost, until `receiver` returns a text other than
/// `previous`. @return that text
template <typename Receiver, typename Send>
std::string pass(Receiver& receiver, const std::string& previous, bool may_be_lost, Send send) {
  const std::chrono::milliseconds patience = may_be_lost ? 500ms : kPatience;
  const int attempts = may_be_lost ? 20 : 1;
  std::string text;
  for (int attempt = 0; attempt < attempts && text.empty(); ++attempt) {
    send();
    do {
      text = receiver.take(patience);
    } while (!text.empty() && text == previous);
  }
  return text;
}

/// A volatile reader of Cyclone DDS starts with the first heartbeat from another vendor's writer
/// and ignores earlier samples as history. @return the text of the sample that arrived, empty if
/// none did
template <typename Message>
std::string open_the_way(wire::Publication<Message>& publication, Peer& reader) {
  if (!publication.wait_for_matched(1, kPatience) || !reader.match()) {
    return {};
  }
  return pass(reader, {}, true, [&] {
    EXPECT_TRUE(publication.write(filled<Message>(kDistinct, 0, 1'000)));
  });
}

class TopicName {
 public:
  template <typename Message>
  static std::string GetName(int /*number*/) {
    return std::string(wire::Topic<Message>::kName);
  }
};

template <typename Message>
class CycloneOnTopic : public testing::Test {
 protected:
  std::unique_ptr<wire::Participant> participant_ =
      wire::make_participant({.domain = test_domain()}, "fast");
};

template <typename... Message>
testing::Types<Message...> messages_of(const std::tuple<wire::TopicRow<Message>...>& rows);

using Messages = decltype(messages_of(wire::kTopicRows));
TYPED_TEST_SUITE(CycloneOnTopic, Messages, TopicName);

/// One sample of each filling, and more with random values.
constexpr int kSamples = kRandom + 30;

constexpr int filling_of(int sample) {
  return std::min<int>(sample, kRandom);
}

/// Different in each sample, even where the filling ignores it.
constexpr std::uint64_t count_of(int sample) {
  return 1'000'003 * static_cast<std::uint64_t>(sample);
}

TYPED_TEST(CycloneOnTopic, ReadsEveryFieldThatWeWrite) {
  wire::Publication<TypeParam> publication(*this->participant_);
  Peer reader(full_name<TypeParam>(), "reader");
  std::string read = open_the_way(publication, reader);
  ASSERT_FALSE(read.empty());
  for (int sample = 0; sample < kSamples; ++sample) {
    const auto message = filled<TypeParam>(filling_of(sample), 0, count_of(sample));
    read = pass(reader, read, kIsStream<TypeParam>, [&] {
      EXPECT_TRUE(publication.write(message));
    });
    ASSERT_EQ(read, text_of(message)) << "sample " << sample;
  }
}

TYPED_TEST(CycloneOnTopic, WritesEveryFieldThatWeReadAndTheBytesThatWeWrite) {
  Texts<TypeParam> received(*this->participant_);
  Peer writer(full_name<TypeParam>(), "writer");
  ASSERT_TRUE(received.match());
  ASSERT_TRUE(writer.match());
  std::string read;
  for (int sample = 0; sample < kSamples; ++sample) {
    const auto expected = text_of(filled<TypeParam>(filling_of(sample), 0, count_of(sample)));
    read = pass(received, read, kIsStream<TypeParam>, [&] {
      EXPECT_EQ(writer.write(filling_of(sample), 0, count_of(sample)), expected)
          << "sample " << sample;
    });
    ASSERT_EQ(read, expected) << "sample " << sample;
  }
}

TEST(CycloneTopics, DropMessagesLongerThanTheIdlAllows) {
  const auto participant = wire::make_participant({.domain = test_domain()}, "fast");
  wire::Publication<msg::CommandFrame> publication(*participant);
  Peer reader("vdrive/v1/command", "reader");
  const std::string first = open_the_way(publication, reader);
  ASSERT_FALSE(first.empty());
  msg::CommandFrame too_long;
  too_long.axes.resize(msg::MAX_AXES_PER_FRAME + 1);
  ASSERT_TRUE(publication.write(too_long));
  const auto longest = filled<msg::CommandFrame>(kHighest);
  const std::string second = pass(reader, first, false, [&] {
    EXPECT_TRUE(publication.write(longest));
  });
  EXPECT_EQ(second, text_of(longest));
}

/// Two instances with two samples each; awaited() has those that a late reader gets.
struct Sample {
  std::uint64_t instance;
  std::uint64_t count;
};

constexpr std::array kWritten{Sample{1, 10}, Sample{2, 20}, Sample{1, 30}, Sample{2, 40}};

template <typename Message>
std::vector<std::string> awaited() {
  const std::size_t first = wire::Topic<Message>::kName == "event" ? 0 : 2;  // keeps 1,024 or 1
  std::vector<std::string> texts;
  for (std::size_t i = first; i < kWritten.size(); ++i) {
    texts.push_back(text_of(filled<Message>(kDistinct, kWritten[i].instance, kWritten[i].count)));
  }
  return texts;
}

template <typename Message>
class CycloneOnTransientTopic : public CycloneOnTopic<Message> {};

using TransientMessages = testing::Types<msg::AxisParameters, msg::Event, msg::BenchDescription>;
TYPED_TEST_SUITE(CycloneOnTransientTopic, TransientMessages, TopicName);

TYPED_TEST(CycloneOnTransientTopic, GetsWhatEachInstanceKeepsWhenItComesLate) {
  wire::Publication<TypeParam> publication(*this->participant_);
  for (const auto& [instance, count] : kWritten) {
    ASSERT_TRUE(publication.write(filled<TypeParam>(kDistinct, instance, count)));
  }
  Peer reader(full_name<TypeParam>(), "reader");
  const auto expected = awaited<TypeParam>();
  std::vector<std::string> texts;
  while (texts.size() < expected.size()) texts.push_back(reader.take(kPatience));
  EXPECT_THAT(texts, testing::UnorderedElementsAreArray(expected));
}

TYPED_TEST(CycloneOnTransientTopic, KeepsForALatecomerOfFastDdsWhatEachInstanceKeeps) {
  Peer writer(full_name<TypeParam>(), "writer");
  for (const auto& [instance, count] : kWritten) {
    ASSERT_FALSE(writer.write(kDistinct, instance, count).empty());
  }
  Texts<TypeParam> received(*this->participant_);
  const auto expected = awaited<TypeParam>();
  std::vector<std::string> texts;
  while (texts.size() < expected.size()) texts.push_back(received.take(kPatience));
  EXPECT_THAT(texts, testing::UnorderedElementsAreArray(expected));
}

template <typename Message>
class BoundsOfTopic : public testing::Test {};

TYPED_TEST_SUITE(BoundsOfTopic, Messages, TopicName);

TYPED_TEST(BoundsOfTopic, AreThoseOfTheIdl) {
  TypeParam message;
  reach_bounds(message, [&message](bool is_within, std::string_view sequence) {
    std::vector<std::byte> sample(wire::encoded_size(message));
    ASSERT_EQ(wire::encode(message, sample), sample.size());
    TypeParam received;
    EXPECT_EQ(wire::decode_checked(sample, received),
              is_within ? wire::Decoding::good : wire::Decoding::beyond_bounds)
        << sequence;
  });
}

}  // namespace
}  // namespace vdrive::test

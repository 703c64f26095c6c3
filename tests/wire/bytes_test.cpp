// SPDX-License-Identifier: Apache-2.0
// For random values of every message type of our IDL files: Fast DDS reads our bytes, we read its
// bytes, and both write the same ones. The second vendor is tested in tests/vendor and tests/ros2.
#include "message_support.hpp"
#include "ros_messages_description.hpp"
#include "support/message_json.hpp"
#include "vdrive/wire/cdr.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/topics.hpp"

#if __has_include("fast_vdrive_messages.h")
#include "wire/fast_cdr_2.hpp"
#else
#include "wire/fast_cdr_3.hpp"
#endif

#include <gtest/gtest.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace vdrive::wire {
namespace {

using Bytes = std::vector<std::byte>;

template <typename Ours, typename Fast, bool kIsTopic>
struct Pair {
  using Message = Ours;
  using FastMessage = Fast;
  static constexpr bool kHasTopic = kIsTopic;
};

template <typename Ours, typename Fast>
using OfTopic = Pair<Ours, Fast, true>;
template <typename Ours, typename Fast>
using OfRos = Pair<Ours, Fast, false>;

namespace fast = vdrive::fast_msg;

using Types = testing::Types<
    OfTopic<msg::CommandFrame, fast::CommandFrame>, OfTopic<msg::CommandReply, fast::CommandReply>,
    OfTopic<msg::Request, fast::Request>, OfTopic<msg::Reply, fast::Reply>,
    OfTopic<msg::StatusFrame, fast::StatusFrame>, OfTopic<msg::AxisStatus, fast::AxisStatus>,
    OfTopic<msg::AxisParameters, fast::AxisParameters>, OfTopic<msg::Event, fast::Event>,
    OfTopic<msg::BenchDescription, fast::BenchDescription>,
    OfTopic<msg::BenchState, fast::BenchState>, OfTopic<msg::SessionName, fast::SessionName>,
    OfTopic<msg::BenchSession, fast::BenchSession>,
    OfRos<std_msgs::msg::dds_::Bool_, std_msgs::msg::fast_msg::Bool_>,
    OfRos<rosgraph_msgs::msg::dds_::Clock_, rosgraph_msgs::msg::fast_msg::Clock_>,
    OfRos<sensor_msgs::msg::dds_::JointState_, sensor_msgs::msg::fast_msg::JointState_>,
    OfRos<trajectory_msgs::msg::dds_::JointTrajectory_,
          trajectory_msgs::msg::fast_msg::JointTrajectory_>,
    OfRos<diagnostic_msgs::msg::dds_::DiagnosticArray_,
          diagnostic_msgs::msg::fast_msg::DiagnosticArray_>,
    OfRos<rcl_interfaces::msg::dds_::Log_, rcl_interfaces::msg::fast_msg::Log_>>;

/// Fills a message with random values: numbers with any bits, lengths from zero to the bound.
class Filler {
 public:
  explicit Filler(unsigned seed) : random_(seed) {}

  template <DescribedStruct Struct>
  void fill(Struct& value) {
    for_each_member<Struct>([&](const auto& member) {
      fill(member, value.*member.pointer);
    });
  }

 private:
  template <CdrNumber Number>
  void fill(const MemberTraits& /*member*/, Number& number) {
    if constexpr (std::is_same_v<Number, bool>) {
      number = (random_() & 1U) != 0;
    } else if constexpr (std::is_same_v<Number, double>) {
      number = static_cast<double>(static_cast<std::int64_t>(random_())) / 3.0;  // never NaN
    } else {
      number = static_cast<Number>(random_());
    }
  }

  template <std::size_t kBound>
  void fill(const MemberTraits& /*member*/, Text<kBound>& text) {
    text = any_text(kBound);
  }

  void fill(const MemberTraits& /*member*/, std::string& text) { text = any_text(40); }

  template <DescribedStruct Struct>
  void fill(const MemberTraits& /*member*/, Struct& value) {
    fill(value);
  }

  template <typename Element>
  void fill(const MemberTraits& member, std::vector<Element>& elements) {
    constexpr std::size_t kMostOfManyThings = 9;
    const std::size_t most = member.bound == 0 ? kMostOfManyThings : member.bound;
    const std::size_t count = random_() % 4 == 0 ? most : random_() % (most + 1);
    elements.resize(count);
    for (Element& element : elements) fill(member, element);
  }

  std::string any_text(std::size_t most) {
    std::string text(random_() % (most + 1), '?');
    for (char& character : text) character = static_cast<char>('!' + random_() % 90);
    return text;
  }

  std::mt19937_64 random_;
};

template <typename Message>
Bytes written(const Message& message, CdrWriter::Order order = CdrWriter::Order::native) {
  CdrWriter size({});
  size.put(message);
  Bytes bytes(size.size(), std::byte{0x55});
  CdrWriter writer(bytes, order);
  writer.put(message);
  EXPECT_TRUE(writer.is_good());
  return bytes;
}

FastBuffer buffer_of(Bytes& bytes) {
  return {reinterpret_cast<char*>(bytes.data()), bytes.size()};
}

template <typename FastMessage>
FastMessage read_by_library(Bytes bytes) {
  FastBuffer buffer = buffer_of(bytes);
  Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, kPlainCdr);
  cdr.read_encapsulation();
  FastMessage message;
  read_by_fast_dds(cdr, message);
  EXPECT_EQ(length_of(cdr), bytes.size()) << "it reads all of it";
  return message;
}

template <typename FastMessage>
Bytes written_by_library(const FastMessage& message, Cdr::Endianness order) {
  Bytes bytes(kEncapsulation + size_by_fast_dds(message));
  FastBuffer buffer = buffer_of(bytes);
  Cdr cdr(buffer, order, kPlainCdr);
  cdr.serialize_encapsulation();
  write_by_fast_dds(cdr, message);
  bytes.resize(length_of(cdr));
  return bytes;
}

template <typename Message>
Message read(const Bytes& bytes) {
  Message message;
  CdrReader reader(bytes);
  reader.get(message);
  EXPECT_TRUE(reader.is_good());
  EXPECT_EQ(reader.position(), bytes.size()) << "all of it is read";
  return message;
}

template <typename Pair>
class BytesOf : public testing::Test {};

class PairName {
 public:
  template <typename Pair>
  static std::string GetName(int /*number*/) {
    std::string name(Description<typename Pair::Message>::kName);
    return name.substr(name.rfind(':') + 1);
  }
};

TYPED_TEST_SUITE(BytesOf, Types, PairName);

constexpr unsigned kSeeds = 50;

TYPED_TEST(BytesOf, AreThoseOfFastDdsInBothByteOrders) {
  using Message = typename TypeParam::Message;
  using FastMessage = typename TypeParam::FastMessage;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE("Filler(" + std::to_string(seed) + ")");
    Message message;
    Filler(seed).fill(message);
    const Bytes ours = written(message);
    const auto theirs = read_by_library<FastMessage>(ours);
    EXPECT_EQ(written_by_library(theirs, Cdr::LITTLE_ENDIANNESS), ours) << json_of(message);
    EXPECT_TRUE(read<Message>(ours) == message) << json_of(message);
    const Bytes big_endian = written(message, CdrWriter::Order::big_endian);
    EXPECT_EQ(written_by_library(theirs, Cdr::BIG_ENDIANNESS), big_endian);
    EXPECT_TRUE(read<Message>(big_endian) == message) << json_of(message);
  }
}

TYPED_TEST(BytesOf, EndEarlyInNoSampleThatIsRead) {
  using Message = typename TypeParam::Message;
  Message message;
  Filler(3).fill(message);
  const Bytes bytes = written(message);
  const std::size_t step = 1 + bytes.size() / 500;
  for (std::size_t size = 0; size < bytes.size(); size += step) {
    Message cut;
    CdrReader reader(std::span<const std::byte>(bytes).first(size));
    reader.get(cut);
    EXPECT_FALSE(reader.is_good()) << size;
  }
}

TYPED_TEST(BytesOf, HaveTheKeyAndTheLargestSizeOfFastDds) {
  using Message = typename TypeParam::Message;
  using FastMessage = typename TypeParam::FastMessage;
  if constexpr (TypeParam::kHasTopic) {
    const TopicId topic = Topic<Message>::kId;
    const std::size_t largest = kEncapsulation + largest_by_fast_dds<FastMessage>();
    EXPECT_LE(support_of(topic).largest_sample, largest);
    EXPECT_LE(largest, support_of(topic).largest_sample + kLargestExceedsBy);
    EXPECT_EQ(traits_of(topic).has_key, has_key_by_fast_dds<FastMessage>());
    Message message;
    Filler(1).fill(message);
    const auto theirs = read_by_library<FastMessage>(written(message));
    Bytes key(kKeyHashSize);
    FastBuffer buffer = buffer_of(key);
    Cdr cdr(buffer, Cdr::BIG_ENDIANNESS, kPlainCdr);
    write_key_by_fast_dds(cdr, theirs);
    for (const auto order : {CdrWriter::Order::native, CdrWriter::Order::big_endian}) {
      const MessageKey ours = support_of(topic).key(written(message, order));
      EXPECT_EQ(Bytes(ours.bytes.begin(), ours.bytes.end()), key);
      EXPECT_EQ(ours.size, length_of(cdr));
    }
  }
}

Bytes sample_of(const std::vector<int>& numbers) {
  Bytes bytes;
  for (const int number : numbers) bytes.push_back(static_cast<std::byte>(number));
  return bytes;
}

TEST(BytesOfNumbers, AreAlignedEachToItsSize) {
  Bytes bytes;
  write_sample(bytes, [](CdrWriter& writer) {
    writer.put(std::uint8_t{1});
    writer.put(std::uint32_t{2});
    writer.put(std::int16_t{-3});
    writer.put(std::uint64_t{4});
  });
  EXPECT_EQ(bytes, sample_of({0,    1,    0, 0,              // CDR, little-endian
                              1,    0,    0, 0, 2, 0, 0, 0,  // three bytes of padding
                              0xFD, 0xFF, 0, 0, 0, 0, 0, 0,  // six bytes of padding
                              4,    0,    0, 0, 0, 0, 0, 0}));
}

TEST(BytesOfText, HaveTheZeroByteAtItsEndAndCountIt) {
  Bytes bytes;
  write_sample(bytes, [](CdrWriter& writer) {
    writer.put(std::string_view("ab"));
  });
  EXPECT_EQ(bytes, sample_of({0, 1, 0, 0, 3, 0, 0, 0, 'a', 'b', 0}));
}

TEST(BytesOfSequence, CanBeOneNumberOfEachElement) {
  const std::vector<std::string> names{"a", "bcd"};
  const auto length = [](const std::string& name) {
    return static_cast<std::uint16_t>(name.size());
  };
  for (const auto order : {CdrWriter::Order::native, CdrWriter::Order::big_endian}) {
    const std::vector<std::uint16_t> lengths{1, 3};
    Bytes expected(12);
    CdrWriter(expected, order).put(lengths);
    Bytes bytes(12);
    CdrWriter writer(bytes, order);
    writer.put(names, length);
    EXPECT_EQ(bytes, expected);
    EXPECT_EQ(writer.size(), 12U);
    CdrWriter none({}, order);
    none.put(names, length);
    EXPECT_EQ(none.size(), 12U) << "what does not fit is counted";
  }
}

TEST(BytesOfText, AreCutAtTheBoundAndAtTheFirstNul) {
  msg::SessionName name;
  name.program = std::string(70, 'p');
  name.host = std::string_view("ho\0st", 5);
  EXPECT_EQ(name.program, std::string(64, 'p'));
  EXPECT_EQ(name.host, "ho");
  EXPECT_EQ(read<msg::SessionName>(written(name)), name);
}

TEST(BytesOfBoolean, AreZeroAndOneOnly) {
  std_msgs::msg::dds_::Bool_ value;
  Bytes bytes = written(value);
  for (const unsigned byte : {0U, 1U, 2U, 0x80U, 0xFFU}) {
    bytes.back() = static_cast<std::byte>(byte);
    CdrReader reader(bytes);
    reader.get(value);
    EXPECT_EQ(reader.is_good(), byte <= 1) << byte;
    EXPECT_EQ(value.data, byte == 1) << byte;
  }
}

TEST(BytesOfSequence, ThatClaimsMoreThanTheSampleHasTakeNoMemory) {
  sensor_msgs::msg::dds_::JointState_ state;
  Bytes bytes = written(state);
  bytes[bytes.size() - 4] =
      std::byte{0xFF};  // the length of `effort`: 255 numbers that are missing
  sensor_msgs::msg::dds_::JointState_ cut;
  CdrReader reader(bytes);
  reader.get(cut);
  EXPECT_FALSE(reader.is_good());
  EXPECT_EQ(cut.effort.capacity(), 0U);
}

}  // namespace
}  // namespace vdrive::wire

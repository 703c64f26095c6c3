// SPDX-License-Identifier: Apache-2.0
// Real participants on loopback, in a separate domain.
#include "vdrive/wire/topics.hpp"

#include "support/test_domain.hpp"
#include "vdrive/wire/address.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

namespace vdrive::wire {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 40s;

NetworkSettings loopback() {
  return {.domain = test::test_domain()};
}

/// Collects messages and waits for them.
template <typename Message>
class Received {
 public:
  typename Subscription<Message>::Handler handler() {
    return [this](const Message& message, const Source& source) {
      const std::lock_guard lock(mutex_);
      messages_.push_back(message);
      sources_.push_back(source);
      changed_.notify_all();
    };
  }

  bool wait_for(std::size_t count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] {
      return messages_.size() >= count;
    });
  }

  std::vector<Message> messages() {
    const std::lock_guard lock(mutex_);
    return messages_;
  }

  Source source() {
    const std::lock_guard lock(mutex_);
    return sources_.at(0);
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Message> messages_;
  std::vector<Source> sources_;
};

template <typename Message>
class EveryTopic : public testing::Test {};

template <typename... Message>
testing::Types<Message...> messages_of(const std::tuple<TopicRow<Message>...>& rows);

using Messages = decltype(messages_of(kTopicRows));

class TopicName {
 public:
  template <typename Message>
  static std::string GetName(int /*number*/) {
    return std::string(Topic<Message>::kName);
  }
};

TYPED_TEST_SUITE(EveryTopic, Messages, TopicName);

TYPED_TEST(EveryTopic, CarriesItsMessageToAnotherParticipant) {
  const auto sender = make_participant(loopback(), "sender");
  const auto receiver = make_participant(loopback(), "receiver");
  Received<TypeParam> received;
  Publication<TypeParam> publication(*sender);
  Subscription<TypeParam> subscription(*receiver, received.handler());
  ASSERT_TRUE(publication.wait_for_matched(1, kPatience));
  ASSERT_TRUE(subscription.wait_for_matched(1, kPatience));
  TypeParam message;
  message.bench = 77;
  ASSERT_TRUE(publication.write(message));
  ASSERT_TRUE(received.wait_for(1));
  EXPECT_EQ(received.messages().front().bench, 77U);
  EXPECT_EQ(subscription.malformed(), 0U);
  EXPECT_TRUE(subscription.wait_for_match(received.source(), 0ms));
}

// Each message is sent after the previous one has arrived. The channel sleeps after a message for
// which it waited, and at most one more waits for it then: 20 messages need at least 5 pauses, also
// if a datagram of another topic wakes it now and then.
TEST(CoalescingParticipant, SleepsBetweenMessagesThatArriveOneByOne) {
  NetworkSettings observer = loopback();
  observer.receive_coalescing = 20ms;
  const auto sender = make_participant(loopback(), "sender");
  const auto receiver = make_participant(observer, "receiver");
  Received<msg::Request> received;
  Publication<msg::Request> publication(*sender);
  Subscription<msg::Request> subscription(*receiver, received.handler());
  ASSERT_TRUE(publication.wait_for_matched(1, kPatience));
  ASSERT_TRUE(subscription.wait_for_matched(1, kPatience));
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t count = 1; count <= 20; ++count) {
    ASSERT_TRUE(publication.write({}));
    ASSERT_TRUE(received.wait_for(count));
  }
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 5 * 20ms);
}

// The library permanently keeps some samples that were acknowledged while a reader joined. A later
// reader then gets a gap over all numbers since, and a guard refuses gaps wider than 65,536.
TEST(LateReader, GetsTheNextReplyOfAWriterThatSentManyWhileOthersJoined) {
  constexpr std::uint64_t kReplies = 70'000;
  constexpr int kJoins = 60;
  const auto nothing = [](const msg::Reply& /*reply*/, const Source& /*source*/) {};
  const auto service = make_participant(loopback(), "service");
  const auto client = make_participant(loopback(), "client");
  Publication<msg::Reply> replies(*service);
  const Subscription<msg::Reply> stays(*client, nothing);
  ASSERT_TRUE(replies.wait_for_matched(1, kPatience));
  std::atomic<bool> joined{false};
  std::thread joins([&] {
    for (int join = 0; join < kJoins; ++join) {
      const auto other = make_participant(loopback(), "other");
      Subscription<msg::Reply> reader(*other, nothing);
      EXPECT_TRUE(reader.wait_for_matched(1, kPatience));
    }
    joined = true;
  });
  const msg::Reply reply;
  std::uint64_t sent = 0;
  while (!joined || sent < kReplies) {
    EXPECT_TRUE(replies.write(reply));
    ++sent;
    // Like clients that ask while others join: one reply after the other. A full history would lose
    // its oldest sample, so it must never fill up.
    if (!joined || sent % 512 == 0) {
      EXPECT_TRUE(replies.wait_for_acknowledged(kPatience));
    }
  }
  joins.join();

  const auto late = make_participant(loopback(), "late");
  Received<msg::Reply> received;
  Subscription<msg::Reply> reader(*late, received.handler());
  ASSERT_TRUE(replies.wait_for_match(late->source(), kPatience));
  ASSERT_TRUE(reader.wait_for_matched(1, kPatience));
  EXPECT_TRUE(replies.write(reply));
  EXPECT_TRUE(received.wait_for(1)) << "[deadline] after " << sent << " replies";
}

TEST(Participant, KnowsOtherParticipantsByTheBeginningOfTheirNames) {
  const auto sut = make_participant(settings(), "vdrived 1");
  const auto first = make_participant(settings(), "vdrived 2");
  NetworkSettings with_place = settings();
  with_place.place = "process 30 on a host";
  const auto second = make_participant(with_place, "vdrived 30");
  const auto third = make_participant(settings(), "other vdrived");
  // Participants are discovered before their writers, so wait until each has a writer that matches.
  Subscription<msg::BenchState> reader(*sut, [](const msg::BenchState&, const Source&) {});
  const Publication<msg::BenchState> of_first(*first);
  const Publication<msg::BenchState> of_second(*second);
  const Publication<msg::BenchState> of_third(*third);
  ASSERT_TRUE(reader.wait_for_matched(3, kPatience));
  EXPECT_EQ(sut->presence().others().size(), 3U) << "not itself";
  EXPECT_EQ(sut->presence().others("vdrived ").size(), 2U);
  EXPECT_EQ(sut->presence().others("nobody").size(), 0U);
  const auto named = sut->presence().others("vdrived 3");
  ASSERT_EQ(named.size(), 1U);
  EXPECT_EQ(named[0].name, "vdrived 30");
  EXPECT_EQ(named[0].source, second->source());
  EXPECT_FALSE(named[0].is_closed);
  EXPECT_EQ(named[0].place, "process 30 on a host");
  EXPECT_EQ(sut->presence().others("vdrived 2").at(0).place, "")
      << "nothing is shown unless it is set";
}

TEST(Participant, RefusesADomainThatDoesNotExist) {
  try {
    const auto participant = make_participant({.domain = 233}, "test");
    FAIL() << "domain 233 was accepted";
  } catch (const NetworkError& error) {
    EXPECT_STREQ(error.what(), "DDS domain 233 is above the highest domain 232");
  }
}

TEST(Participant, RefusesAnInvalidAddress) {
  EXPECT_THROW(static_cast<void>(make_participant({.domain = 1, .interfaces = {"no one"}}, "test")),
               NetworkError);
  EXPECT_THROW(static_cast<void>(make_participant({.domain = 1, .peers = {"some where"}}, "test")),
               NetworkError);
  for (const char* server : {"10.0.0.9", "10.0.0.9:", "10.0.0.9:0", "10.0.0.9:65536",
                             "a server:11811", "10.0.0.9:11811 ", ":11811"}) {
    EXPECT_FALSE(parse_server_address(server)) << server;
    EXPECT_THROW(
        static_cast<void>(make_participant({.domain = 1, .discovery_servers = {server}}, "test")),
        NetworkError)
        << server;
  }
  EXPECT_EQ(parse_server_address("10.0.0.9:65535").value().port, 65535);
}

TEST(Participant, RefusesAnAddressThatNoInterfaceHas) {
  try {
    // 192.0.2.0/24 is reserved for documentation (RFC 5737), so no machine has it.
    const auto participant = make_participant({.domain = 1, .interfaces = {"192.0.2.1"}}, "test");
    FAIL() << "an interface that is not there was accepted";
  } catch (const NetworkError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("192.0.2.1"));
    EXPECT_THAT(error.what(), testing::HasSubstr("127.0.0.1"));
  }
}

/// @return the largest receive buffer of the UDP sockets of this process [bytes].
int largest_receive_buffer() {
  int largest = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int file = std::stoi(entry.path().filename().string());
    int kind = 0;
    int size = 0;
    socklen_t length = sizeof kind;
    if (getsockopt(file, SOL_SOCKET, SO_TYPE, &kind, &length) != 0 || kind != SOCK_DGRAM) continue;
    length = sizeof size;
    if (getsockopt(file, SOL_SOCKET, SO_RCVBUF, &size, &length) == 0) {
      largest = std::max(largest, size);
    }
  }
  return largest;
}

// socket(7): the kernel doubles the requested size after clamping it to the limit.
TEST(Participant, UsesTheReceiveBufferThatTheKernelPermits) {
  std::ifstream file("/proc/sys/net/core/rmem_max");
  int limit = 0;
  ASSERT_TRUE(file >> limit);
  auto network = loopback();
  for (const auto& [role, wanted] :
       {std::pair(Role::service, 4 << 20), std::pair(Role::client, 16 << 20)}) {
    network.role = role;
    const auto participant = make_participant(network, "test");
    EXPECT_EQ(largest_receive_buffer(), 2 * std::min(limit, wanted));
  }
}

TEST(Participant, FindsANamedPeer) {
  auto with_peer = loopback();
  with_peer.peers = {"127.0.0.1"};
  const auto sender = make_participant(with_peer, "sender");
  const auto receiver = make_participant(with_peer, "receiver");
  Publication<msg::Event> publication(*sender);
  const Subscription<msg::Event> subscription(*receiver, [](const auto&, const auto&) {});
  EXPECT_TRUE(publication.wait_for_matched(1, kPatience));
}

TEST(Subscription, DropsAndCountsMessagesLongerThanTheIdlAllows) {
  const auto participant = make_participant(loopback(), "both");
  Received<msg::CommandFrame> good;
  Received<msg::CommandFrame> bad;
  Publication<msg::CommandFrame> publication(*participant);
  Subscription<msg::CommandFrame> subscription(*participant, good.handler(), bad.handler());
  ASSERT_TRUE(publication.wait_for_matched(1, kPatience));
  msg::CommandFrame too_many_axes;
  too_many_axes.axes.resize(msg::MAX_AXES_PER_FRAME + 1);
  ASSERT_TRUE(publication.write(too_many_axes));
  msg::CommandFrame too_many_objects;
  too_many_objects.axes.resize(1);
  too_many_objects.axes[0].objects.resize(msg::MAX_OBJECTS_PER_AXIS + 1);
  ASSERT_TRUE(publication.write(too_many_objects));
  msg::CommandFrame largest;
  largest.axes.resize(msg::MAX_AXES_PER_FRAME);
  for (auto& axis : largest.axes) axis.objects.resize(msg::MAX_OBJECTS_PER_AXIS);
  ASSERT_TRUE(publication.write(largest));
  ASSERT_TRUE(good.wait_for(1));
  ASSERT_TRUE(bad.wait_for(2));
  EXPECT_EQ(good.messages().size(), 1U);
  EXPECT_EQ(good.messages()[0].axes.size(), msg::MAX_AXES_PER_FRAME);
  EXPECT_EQ(subscription.malformed(), 2U);
}

TEST(Subscription, ReceivesMessagesAboveTheSizeOfADatagram) {
  const auto sender = make_participant(loopback(), "sender");
  const auto receiver = make_participant(loopback(), "receiver");
  Received<msg::CommandFrame> received;
  Publication<msg::CommandFrame> publication(*sender);
  Subscription<msg::CommandFrame> subscription(*receiver, received.handler());
  ASSERT_TRUE(publication.wait_for_matched(1, kPatience));
  ASSERT_TRUE(subscription.wait_for_matched(1, kPatience));
  msg::CommandFrame frame;  // 256 axes with 8 objects each, 41 kB: the longest possible message
  frame.axes.resize(msg::MAX_AXES_PER_FRAME);
  for (auto& axis : frame.axes) axis.objects.resize(msg::MAX_OBJECTS_PER_AXIS);
  ASSERT_TRUE(publication.write(frame));
  ASSERT_TRUE(received.wait_for(1));
  EXPECT_EQ(received.messages()[0], frame);
}

TEST(Subscription, ReceivesEveryAxisOfALargeBenchAsAnInstance) {
  constexpr std::uint16_t kAxes = 2'000;
  const auto sender = make_participant(loopback(), "sender");
  Publication<msg::AxisParameters> publication(*sender);
  for (std::uint16_t axis = 1; axis <= kAxes; ++axis) {
    msg::AxisParameters parameters;
    parameters.bench = 1;
    parameters.axis = axis;
    ASSERT_TRUE(publication.write(parameters)) << axis;
  }
  const auto receiver = make_participant(loopback(), "latecomer");
  Received<msg::AxisParameters> received;
  const Subscription<msg::AxisParameters> subscription(*receiver, received.handler());
  ASSERT_TRUE(received.wait_for(kAxes));
  std::set<std::uint16_t> axes;
  for (const auto& message : received.messages()) axes.insert(message.axis);
  EXPECT_EQ(axes.size(), kAxes);
}

TEST(Subscription, CreatedLateReceivesTheLastThousandEventsInOrder) {
  constexpr std::uint64_t kWritten = 1'500;
  constexpr std::size_t kKept = 1'024;
  const auto sender = make_participant(loopback(), "sender");
  Publication<msg::Event> publication(*sender);
  for (std::uint64_t tick = 1; tick <= kWritten; ++tick) {
    msg::Event event;
    event.bench = 1;
    event.tick = tick;
    ASSERT_TRUE(publication.write(event));
  }
  const auto receiver = make_participant(loopback(), "latecomer");
  Received<msg::Event> received;
  const Subscription<msg::Event> subscription(*receiver, received.handler());
  ASSERT_TRUE(received.wait_for(kKept));
  const auto events = received.messages();
  ASSERT_EQ(events.size(), kKept);
  for (std::size_t position = 0; position < kKept; ++position) {
    EXPECT_EQ(events[position].tick, kWritten - kKept + 1 + position);
  }
}

TEST(Publication, AnswersWithinOneProcessWithoutADeadlock) {
  const auto service = make_participant(loopback(), "service");
  const auto client = make_participant(loopback(), "client");
  Publication<msg::Reply> replies(*service);
  Received<msg::Reply> received;
  std::mutex mutex;
  std::condition_variable asked;
  std::uint64_t wanted = 0;
  const Subscription<msg::Request> requests(*service, [&](const auto& request, const auto&) {
    const std::lock_guard lock(mutex);
    wanted = request.request_id;
    asked.notify_all();
  });
  Publication<msg::Request> questions(*client);
  Subscription<msg::Reply> answers(*client, received.handler());
  ASSERT_TRUE(questions.wait_for_matched(1, kPatience));
  ASSERT_TRUE(answers.wait_for_matched(1, kPatience));
  ASSERT_TRUE(replies.wait_for_matched(1, kPatience));
  for (std::uint64_t number = 1; number <= 100; ++number) {
    msg::Request request;
    request.request_id = number;
    ASSERT_TRUE(questions.write(request));
    std::unique_lock lock(mutex);
    ASSERT_TRUE(asked.wait_for(lock, kPatience, [&] {
      return wanted == number;
    }));
    lock.unlock();
    msg::Reply reply;
    reply.request_id = number;
    ASSERT_TRUE(replies.write(reply));
    ASSERT_TRUE(received.wait_for(number));
  }
}

TEST(Publication, ReportsWhetherTheSenderOfAMessageSubscribes) {
  const auto service = make_participant(loopback(), "service");
  const auto client = make_participant(loopback(), "client");
  Received<msg::Request> received;
  Publication<msg::Reply> replies(*service);
  Subscription<msg::Request> requests(*service, received.handler());
  Publication<msg::Request> questions(*client);
  ASSERT_TRUE(questions.wait_for_matched(1, kPatience));
  ASSERT_TRUE(questions.write(msg::Request{}));
  ASSERT_TRUE(received.wait_for(1));
  EXPECT_FALSE(replies.wait_for_match(received.source(), 0ms));
  const Subscription<msg::Reply> answers(*client, [](const auto&, const auto&) {});
  EXPECT_TRUE(replies.wait_for_match(received.source(), kPatience));
}

TEST(Publication, ForgetsADepartedParticipant) {
  const auto service = make_participant(loopback(), "service");
  Publication<msg::Event> publication(*service);
  {
    const auto client = make_participant(loopback(), "client");
    const Subscription<msg::Event> subscription(*client, [](const auto&, const auto&) {});
    ASSERT_TRUE(publication.wait_for_matched(1, kPatience));
  }
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (publication.matched() > 0 && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::yield();
  }
  EXPECT_EQ(publication.matched(), 0U);
}

}  // namespace
}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
// The local bus, used through publications and subscriptions.
#include "vdrive/wire/local_bus.hpp"

#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::wire {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

class LocalBusTest : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<Participant> join(const std::string& name,
                                                  Role role = Role::other) const {
    return make_participant(settings(role), name);
  }

  [[nodiscard]] NetworkSettings settings(Role role) const {
    NetworkSettings settings;
    settings.role = role;
    settings.bus = bus_;
    return settings;
  }

  std::shared_ptr<LocalBus> bus_ = std::make_shared<LocalBus>();
};

msg::Event event(std::uint32_t bench, std::uint64_t tick) {
  msg::Event event;
  event.bench = bench;
  event.tick = tick;
  return event;
}

TEST_F(LocalBusTest, DeliversBeforeTheWriteReturns) {
  const auto sender = join("sender");
  const auto receiver = join("receiver");
  std::vector<std::uint64_t> ticks;
  const Subscription<msg::BenchState> subscription(
      *receiver, [&](const msg::BenchState& state, const Source& source) {
        EXPECT_EQ(source, sender->source());
        ticks.push_back(state.tick);
      });
  Publication<msg::BenchState> publication(*sender);
  msg::BenchState state;
  state.tick = 4;
  ASSERT_TRUE(publication.write(state));
  EXPECT_THAT(ticks, ElementsAre(4));
}

TEST_F(LocalBusTest, MatchesAtOnceAndNoMoreAfterTheEnd) {
  const auto one = join("one");
  const auto other = join("other");
  std::vector<std::size_t> seen;
  const auto writer =
      one->make_writer(Topic<msg::Reply>::kId, [&](const std::vector<Source>& matched) {
        seen.push_back(matched.size());
      });
  {
    const auto reader = other->make_reader(Topic<msg::Reply>::kId,
                                           {.take = [](auto) {}, .deliver = [](const auto&) {}});
    EXPECT_TRUE(writer->matches().contains(other->source()));
    EXPECT_FALSE(writer->matches().contains(one->source()));
    EXPECT_EQ(reader->matches().count(), 1U);
  }
  EXPECT_EQ(writer->matches().count(), 0U);
  EXPECT_THAT(seen, ElementsAre(1, 0));
}

// 1,024 events of each bench; no state, whose topic is volatile.
TEST_F(LocalBusTest, KeepsForLaterSubscriptionsWhatTheTopicKeeps) {
  const auto sender = join("sender");
  Publication<msg::Event> events(*sender);
  Publication<msg::BenchState> states(*sender);
  for (std::uint64_t tick = 1; tick <= 1'030; ++tick) ASSERT_TRUE(events.write(event(1, tick)));
  ASSERT_TRUE(events.write(event(2, 5)));
  ASSERT_TRUE(states.write(msg::BenchState()));
  const auto late = join("late");
  std::vector<std::uint64_t> ticks;
  std::size_t of_the_second = 0;
  const Subscription<msg::Event> subscription(*late, [&](const msg::Event& message, const Source&) {
    if (message.bench == 1) ticks.push_back(message.tick);
    if (message.bench == 2) ++of_the_second;
  });
  ASSERT_EQ(ticks.size(), 1'024U);
  EXPECT_EQ(ticks.front(), 7U);
  EXPECT_EQ(ticks.back(), 1'030U);
  EXPECT_EQ(of_the_second, 1U);
  std::size_t received = 0;
  const Subscription<msg::BenchState> volatile_one(*late, [&](const auto&, const Source&) {
    ++received;
  });
  EXPECT_EQ(received, 0U);
}

// The padding between the two members of the key does not belong to it; a sender may leave any
// bytes there.
TEST_F(LocalBusTest, KeepsOneNameOfASessionWhateverStandsInThePadding) {
  msg::SessionName name;
  name.bench = 1;
  name.session = 7;
  std::vector<std::byte> sample(encoded_size(name));
  ASSERT_NE(encode(name, sample), 0U);
  const auto sender = join("sender");
  const auto names = sender->make_writer(Topic<msg::SessionName>::kId);
  EXPECT_TRUE(names->write(sample));
  sample[8] = std::byte{0xFF};  // encapsulation and bench number take eight bytes
  EXPECT_TRUE(names->write(sample));
  const auto late = join("late");
  std::size_t received = 0;
  const Subscription<msg::SessionName> subscription(*late,
                                                    [&](const msg::SessionName&, const Source&) {
                                                      ++received;
                                                    });
  EXPECT_EQ(received, 1U);
}

std::vector<std::string> names_of(const std::vector<OtherParticipant>& others) {
  std::vector<std::string> names;
  names.reserve(others.size());
  for (const auto& other : others) names.push_back(other.name);
  return names;
}

TEST_F(LocalBusTest, KeepsTheNewestNameOfEachSessionOfEachBench) {
  const auto sender = join("sender");
  Publication<msg::SessionName> names(*sender);
  const auto write = [&](std::uint32_t bench, std::uint64_t session, const std::string& program) {
    msg::SessionName name;
    name.bench = bench;
    name.session = session;
    name.program = program;
    EXPECT_TRUE(names.write(name));
  };
  write(1, 7, "old");
  write(1, 8, "other");
  write(2, 7, "same session");
  write(1, 7, "new");
  const auto late = join("late");
  std::vector<std::string> programs;
  const Subscription<msg::SessionName> subscription(
      *late, [&](const msg::SessionName& name, const Source&) {
        programs.emplace_back(name.program.to_string());
      });
  EXPECT_THAT(programs, UnorderedElementsAre("new", "other", "same session"));
}

TEST_F(LocalBusTest, KnowsWhoIsThere) {
  const auto service = join("vdrived 1", Role::service);
  const auto client = join("vdrive client", Role::client);
  const Presence& sut = service->presence();
  Source gone;
  {
    const auto second = join("vdrive client", Role::client);
    gone = second->source();
    EXPECT_THAT(names_of(second->presence().others()), ElementsAre("vdrived 1"))
        << "clients ignore each other";
    EXPECT_THAT(names_of(sut.others()), ElementsAre("vdrive client", "vdrive client"));
    EXPECT_TRUE(sut.is_certain(gone));
  }
  EXPECT_FALSE(sut.is_certain(gone));
  EXPECT_THAT(names_of(sut.others("vdrive ")), ElementsAre("vdrive client"));
  EXPECT_THAT(names_of(sut.others("vdrived")), IsEmpty());
  EXPECT_FALSE(sut.may_miss_some());
  EXPECT_FALSE(sut.may_have_double());
  EXPECT_FALSE(sut.may_return());
}

TEST_F(LocalBusTest, KnowsWhoIsThereWhateverTheAgeOfSamples) {
  const auto now = Presence::Clock::time_point(std::chrono::hours(1));
  const auto service = join("vdrived 1", Role::service);
  auto client = join("vdrive client", Role::client);
  const Source source = client->source();
  Presence& sut = service->presence();
  EXPECT_EQ(sut.silence(source, std::nullopt, now), Presence::Clock::duration());
  EXPECT_EQ(sut.silence(source, Presence::Clock::time_point(), now), Presence::Clock::duration());
  client.reset();
  EXPECT_EQ(sut.silence(source, now, now), std::nullopt) << "at once";
  EXPECT_EQ(sut.pulse(), std::nullopt);
  EXPECT_EQ(sut.running_time(now), now);
  EXPECT_EQ(sut.running_time(now + std::chrono::hours(1)), now + std::chrono::hours(1))
      << "pauses of this program do not matter";
  EXPECT_FALSE(sut.is_excused(now));
}

TEST_F(LocalBusTest, RefusesASecondServiceOfOneName) {
  const auto first = join("vdrived 1", Role::service);
  EXPECT_THROW((void)join("vdrived 1", Role::service), NetworkError);
  EXPECT_NO_THROW((void)join("vdrived 2", Role::service));
}

constexpr std::uint32_t kBench = 7;

TEST_F(LocalBusTest, DoesTheWorkOfABenchThatIsThere) {
  const auto client = join("vdrive client", Role::client);
  EXPECT_EQ(client->run_local_work(kBench), LocalWork::none);
  int rounds = 0;
  {
    const LocalBus::WorkPlace place(bus_, kBench,
                                    {.run =
                                         [&] {
                                           return ++rounds <= 2 ? LocalWork::done : LocalWork::none;
                                         },
                                     .has_room = {}});
    EXPECT_EQ(client->run_local_work(kBench), LocalWork::done);
    EXPECT_EQ(client->run_local_work(kBench + 1), LocalWork::none) << "of another bench";
    EXPECT_EQ(client->run_local_work(kBench), LocalWork::done);
    EXPECT_EQ(client->run_local_work(kBench), LocalWork::none);
  }
  EXPECT_EQ(client->run_local_work(kBench), LocalWork::none);
  EXPECT_EQ(rounds, 3);
}

TEST_F(LocalBusTest, MakesRoomByTheWorkOfTheBench) {
  const auto client = join("vdrive client", Role::client);
  EXPECT_TRUE(client->make_room(kBench)) << "there is no such bench";
  int waiting = 3;
  int rounds = 0;
  const LocalBus::WorkPlace place(bus_, kBench,
                                  {.run =
                                       [&] {
                                         ++rounds;
                                         --waiting;
                                         return LocalWork::done;
                                       },
                                   .has_room =
                                       [&] {
                                         return waiting < 2;
                                       }});
  EXPECT_FALSE(client->make_room(kBench)) << "two are left";
  EXPECT_TRUE(client->make_room(kBench));
  EXPECT_TRUE(client->make_room(kBench));
  EXPECT_EQ(rounds, 2) << "where there is room, nothing is done";
}

// A thread works for one bench while others are created and destroyed.
TEST_F(LocalBusTest, LetsABenchEndWhileAThreadWorksForAnotherOne) {
  const auto client = join("vdrive client", Role::client);
  std::promise<void> begun;
  std::promise<void> released;
  const LocalBus::WorkPlace busy(bus_, kBench,
                                 {.run =
                                      [&] {
                                        begun.set_value();
                                        released.get_future().wait();
                                        return LocalWork::done;
                                      },
                                  .has_room = {}});
  std::thread worker([&] {
    client->run_local_work(kBench);
  });
  begun.get_future().wait();
  auto others = std::async(std::launch::async, [&] {
    for (int count = 0; count < 10; ++count) {
      const LocalBus::WorkPlace other(bus_, kBench + 1, {.run = {}, .has_room = {}});
    }
  });
  EXPECT_EQ(others.wait_for(std::chrono::seconds(20)), std::future_status::ready);
  released.set_value();
  worker.join();
}

// More senders than one reader can keep up with, so that one of them is always delivering.
TEST_F(LocalBusTest, LetsASubscriptionJoinWhileSamplesAreDeliveredWithoutAPause) {
  constexpr int kSenders = 4;
  const auto receiver = join("receiver");
  std::atomic<int> received{0};
  const Subscription<msg::BenchState> slow(*receiver, [&](const auto&, const Source&) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(200);
    while (std::chrono::steady_clock::now() < end) {
    }
    ++received;
  });
  std::atomic<bool> ends{false};
  std::vector<std::thread> senders;
  for (int thread = 0; thread < kSenders; ++thread) {
    senders.emplace_back([&] {
      const auto sender = join("sender");
      Publication<msg::BenchState> publication(*sender);
      while (!ends) static_cast<void>(publication.write(msg::BenchState()));
    });
  }
  while (received < 10 * kSenders) std::this_thread::yield();
  auto joined = std::async(std::launch::async, [&] {
    const auto guest = join("guest");
    for (int count = 0; count < 20; ++count) {
      const Subscription<msg::BenchState> passing(*guest, [](const auto&, const Source&) {});
    }
  });
  EXPECT_EQ(joined.wait_for(std::chrono::seconds(20)), std::future_status::ready);
  ends = true;
  for (auto& sender : senders) sender.join();
}

TEST_F(LocalBusTest, CarriesSamplesOfManyThreadsWhileSubscriptionsComeAndGo) {
  constexpr int kThreads = 4;
  constexpr int kSamples = 2'000;
  std::atomic<int> received{0};
  const auto receiver = join("receiver");
  const Subscription<msg::BenchState> steady(*receiver, [&](const auto&, const Source&) {
    ++received;
  });
  std::atomic<bool> ends{false};
  std::thread visitor([&] {
    while (!ends) {
      const auto guest = join("guest");
      const Subscription<msg::BenchState> passing(*guest, [](const auto&, const Source&) {});
    }
  });
  std::vector<std::thread> senders;
  for (int thread = 0; thread < kThreads; ++thread) {
    senders.emplace_back([&] {
      const auto sender = join("sender");
      Publication<msg::BenchState> publication(*sender);
      for (int sample = 0; sample < kSamples; ++sample) {
        static_cast<void>(publication.write(msg::BenchState()));
      }
    });
  }
  for (auto& sender : senders) sender.join();
  ends = true;
  visitor.join();
  EXPECT_EQ(received, kThreads * kSamples);
}

}  // namespace
}  // namespace vdrive::wire

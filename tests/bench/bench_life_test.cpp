// SPDX-License-Identifier: Apache-2.0
// A bench in the user's process: threads, callbacks, its end, and fork.
#include "base/works_for.hpp"
#include "configuration/configuration_file.hpp"
#include "configuration/configuration_help.hpp"
#include "settings/configuration_error.hpp"
#include "support/temporary_directory.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/client.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/subscription.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <future>
#include <latch>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::bench {
namespace {

using client::Axis;
using client::Event;
using client::EventHistory;
using client::Observation;
using client::Outcome;
using client::OutcomeKind;
using client::Session;
using client::StepClock;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr std::array<std::uint32_t, 1> kFirst{1};
constexpr milliseconds kLong{20'000};

/// @return the current tick of the bench.
std::uint64_t tick_of(Session& session) {
  return session.step(1, 0).value();
}

// ---- stepping -----------------------------------------------------------------------------------

TEST(JoinedClocks, OfOneThreadAreRefusedAtOnce) {
  const Bench bench;
  Session first = bench.session();
  Session second = bench.session();
  auto clock = StepClock::join(first, kFirst);
  ASSERT_TRUE(clock) << clock.outcome().message();
  const auto refused = StepClock::join(second, kFirst).outcome();
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(), HasSubstr("this thread has joined the clock of bench 1 already"));
  EXPECT_TRUE(clock->step(5)) << "the refused one is no stepper";
}

TEST(JoinedClocks, AreFreeAgainWhenTheClockOrItsSessionHasEnded) {
  const Bench bench;
  Session second = bench.session();
  {
    Session first = bench.session();
    { ASSERT_TRUE(StepClock::join(first, kFirst)); }
    ASSERT_TRUE(StepClock::join(second, kFirst));
    auto kept = StepClock::join(first, kFirst);
    ASSERT_TRUE(kept);
  }
  EXPECT_TRUE(StepClock::join(second, kFirst));
}

TEST(JoinedClocks, AreFreeAgainWhenTheirSessionWasAbandoned) {
  const Bench bench;
  Session first = bench.session();
  Session second = bench.session();
  const auto kept = StepClock::join(first, kFirst);
  ASSERT_TRUE(kept);
  ASSERT_FALSE(StepClock::join(second, kFirst));
  first.abandon();
  const auto joined = StepClock::join(second, kFirst).outcome();
  EXPECT_TRUE(joined) << joined.message();
}

TEST(JoinedClocks, EndAStepAtItsDeadlineWhileAnotherThreadSteps) {
  const Bench bench;
  Session session = bench.session();
  auto clock = std::async(std::launch::async, [&session] {
                 return StepClock::join(session, kFirst);
               }).get();
  ASSERT_TRUE(clock);
  Session holder = bench.session();
  auto hold = StepClock::join(holder, kFirst);
  ASSERT_TRUE(hold);
  auto other = std::async(std::launch::async, [&clock] {
    return clock->step(2, kLong).outcome();
  });
  // When the first of its two ticks has passed, the other thread is inside its step.
  ASSERT_TRUE(hold->step(1, kLong));
  const Outcome late = clock->step(1, milliseconds(100)).outcome();
  EXPECT_EQ(late.kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.message(), HasSubstr("another thread steps this clock"));
  ASSERT_TRUE(hold->step(1, kLong));
  EXPECT_TRUE(other.get());
}

TEST(JoinedClocks, OfTwoThreadsStepTogetherInTheThreadsThatGrant) {
  constexpr std::uint64_t kSteps = 300;
  const Bench bench({.axes = 2});
  const auto run = [&bench] {
    Session session = bench.session();
    auto clock = StepClock::join(session, kFirst);
    if (!clock) return clock.outcome();
    for (std::uint64_t step = 1; step <= kSteps; ++step) {
      if (const auto reached = clock->step(1, kLong); !reached) return reached.outcome();
    }
    return Outcome();
  };
  // A stepper that has joined stops the time until both threads have joined.
  Session holder = bench.session();
  auto hold = StepClock::join(holder, kFirst);
  ASSERT_TRUE(hold);
  auto one = std::async(std::launch::async, run);
  auto two = std::async(std::launch::async, run);
  const auto reached = hold->step(kSteps, kLong);
  EXPECT_TRUE(reached) << reached.outcome().message();
  hold = Outcome::failed("left");
  EXPECT_TRUE(one.get());
  EXPECT_TRUE(two.get());
}

TEST(Steps, OfTwoThreadsFollowEachOther) {
  constexpr std::uint64_t kSteps = 500;
  const Bench bench({.axes = 2});
  Session session = bench.session();
  Session other = bench.session();
  const std::uint64_t begin = tick_of(session);
  const auto run = [](Session& stepped) {
    std::vector<std::uint64_t> reached;
    for (std::uint64_t step = 0; step < kSteps; ++step) {
      reached.push_back(stepped.step(1, 3).value());
    }
    return reached;
  };
  auto one = std::async(std::launch::async, run, std::ref(session));
  auto two = std::async(std::launch::async, run, std::ref(session));
  auto three = std::async(std::launch::async, run, std::ref(other));
  std::vector<std::uint64_t> all = one.get();
  for (auto* const steps : {&two, &three}) {
    const auto reached = steps->get();
    all.insert(all.end(), reached.begin(), reached.end());
  }
  std::ranges::sort(all);
  EXPECT_EQ(std::ranges::adjacent_find(all), all.end()) << "each step has ticks of its own";
  EXPECT_EQ(all.back() - begin, 3U * 3U * kSteps);
}

TEST(Steps, OfTwoThreadsThroughOneJoinedClockFollowEachOther) {
  constexpr std::uint64_t kSteps = 2'000;
  const Bench bench;
  Session session = bench.session();
  auto clock = StepClock::join(session, kFirst);
  ASSERT_TRUE(clock);
  const std::uint64_t begin = tick_of(session);
  std::latch both_are_here(2);
  const auto run = [&] {
    both_are_here.arrive_and_wait();
    for (std::uint64_t step = 0; step < kSteps; ++step) {
      if (!clock->step(2) || !session.step(1, 1)) return false;
    }
    return true;
  };
  auto one = std::async(std::launch::async, run);
  EXPECT_TRUE(run());
  EXPECT_TRUE(one.get());
  EXPECT_EQ(tick_of(session) - begin, 2U * 3U * kSteps);
}

/// More ticks than can be run in a day.
constexpr std::uint64_t kEndless = 1'000'000'000'000;

/// Runs an endless step of a joined clock in another thread and calls `end` with the bench and the
/// session once the step has begun. @return the outcome of the step.
template <typename End>
Outcome step_until(const End& end) {
  std::optional<Bench> bench(std::in_place);
  Session session = bench->session();
  Session other = bench->session();
  std::latch has_joined(1);
  auto ended = std::async(std::launch::async, [&] {
    auto clock = StepClock::join(session, kFirst);
    has_joined.count_down();
    return clock ? clock->step(kEndless, std::chrono::hours(1)).outcome() : clock.outcome();
  });
  has_joined.wait();
  const std::uint64_t begin = tick_of(other);
  while (tick_of(other) == begin && ended.wait_for(seconds(0)) != std::future_status::ready) {
  }
  end(bench, session);
  if (ended.wait_for(kLong) != std::future_status::ready) {
    ADD_FAILURE() << "the step goes on";
    std::abort();  // nothing else would end it
  }
  return ended.get();
}

TEST(JoinedClocks, EndAStepThatIsUnderWay) {
  EXPECT_EQ(step_until([](std::optional<Bench>& /*bench*/, Session& session) {
              session.interrupt();
            }).message(),
            "interrupted");
  const Outcome lost = step_until([](std::optional<Bench>& bench, Session& /*session*/) {
    bench.reset();
  });
  EXPECT_EQ(lost.kind(), OutcomeKind::lost) << lost.message();
}

TEST(JoinedClocks, ContinueAStepAfterItsPatienceFromWhereItWas) {
  constexpr std::uint64_t kTicks = 200'000;  // some 0.1 s
  const Bench bench;
  Session session = bench.session();
  auto clock = StepClock::join(session, kFirst);
  ASSERT_TRUE(clock);
  const std::uint64_t begin = tick_of(session);
  const auto first = clock->step(kTicks, milliseconds(1));
  ASSERT_EQ(first.outcome().kind(), OutcomeKind::timed_out) << first.outcome().message();
  EXPECT_THAT(first.outcome().message(), testing::MatchesRegex("bench 1 is at tick [0-9]+ of " +
                                                               std::to_string(begin + kTicks)));
  const auto reached = clock->step(kTicks, kLong);
  ASSERT_TRUE(reached) << reached.outcome().message();
  EXPECT_EQ(reached->front(), begin + kTicks);
  EXPECT_EQ(clock->now(), kTicks * milliseconds(1));
}

TEST(JoinedClocks, RefuseMoreTicksThanTheyCount) {
  const Bench bench;
  Session session = bench.session();
  auto clock = StepClock::join(session, kFirst);
  ASSERT_TRUE(clock);
  // 2^63 ns are 9,223,372,036,854.775807 ms.
  EXPECT_EQ(clock->step(9'223'372'036'855).outcome().message(),
            "9223372036855 ticks of 1000 us exceed the range of a clock: at most 9223372036854");
  EXPECT_EQ(clock->now(), std::chrono::nanoseconds(0));
  EXPECT_TRUE(clock->step(1));
}

// ---- callbacks ---------------------------------------------------------------------------------

/// Causes an event that every session receives: a change of state.
Outcome cause_an_event(Session& session) {
  auto axis = session.axis("1.1");
  if (!axis) return axis.outcome();
  if (Outcome enabled = axis->enable(); !enabled) return enabled;
  return axis->disable();
}

TEST(Observer, MayCallTheBench) {
  const Bench bench;
  std::promise<Outcome> moved;
  bool has_moved = false;
  Session session = bench.session();
  session.on_event([&](const Event&) {
    if (std::exchange(has_moved, true)) return;
    auto axis = session.axis("1.2");
    Outcome outcome = axis ? axis->enable() : axis.outcome();
    if (outcome) outcome = axis->move_to(500);
    moved.set_value(outcome);
  });
  ASSERT_TRUE(cause_an_event(session));
  auto ended = moved.get_future();
  ASSERT_EQ(ended.wait_for(kLong), std::future_status::ready);
  const Outcome outcome = ended.get();
  EXPECT_TRUE(outcome) << outcome.message();
}

/// Causes a refusal that no call waits for: the drive has no mode 6060h = 50.
Outcome cause_a_refusal(Session& session) {
  auto axis = session.axis("1.1");
  if (!axis) return axis.outcome();
  if (Outcome enabled = axis->enable(); !enabled) return enabled;
  client::SetPointFrame frame;
  frame.axes.push_back({.axis = 1, .objects = {{.object = {0x6060, 0}, .value = 50}}});
  if (Outcome sent = session.send_set_points(1, {&frame, 1}); !sent) return sent;
  return session.step(1, 1).outcome();
}

TEST(Observer, OfRefusalsMayCallTheBench) {
  const Bench bench;
  std::promise<Outcome> stepped;
  bool has_stepped = false;
  Session session = bench.session();
  session.on_set_point_refusal([&](const client::SetPointRefusal&) {
    if (std::exchange(has_stepped, true)) return;
    stepped.set_value(session.step(1, 1).outcome());
  });
  ASSERT_TRUE(cause_a_refusal(session));
  auto ended = stepped.get_future();
  ASSERT_EQ(ended.wait_for(kLong), std::future_status::ready);
  EXPECT_TRUE(ended.get());
  session.on_set_point_refusal({});
}

TEST(Observer, ThatBlocksHoldsUpNoCall) {
  const Bench bench;
  std::promise<void> begun;
  std::promise<void> released;
  bool has_begun = false;
  Session session = bench.session();
  session.on_event([&](const Event&) {
    if (std::exchange(has_begun, true)) return;
    begun.set_value();
    released.get_future().wait();
  });
  ASSERT_TRUE(cause_an_event(session));
  ASSERT_EQ(begun.get_future().wait_for(kLong), std::future_status::ready);
  auto axis = session.axis("1.1");
  ASSERT_TRUE(axis->enable());
  EXPECT_TRUE(axis->move_to(1'000));
  released.set_value();
}

TEST(Observer, MayEndItsOwnReports) {
  const Bench bench;
  std::promise<void> first;
  std::promise<void> second;
  bool has_begun = false;
  Session session = bench.session();
  session.on_event([&](const Event&) {
    session.on_event([&](const Event&) {
      session.on_event({});
      if (!std::exchange(has_begun, true)) second.set_value();
    });
    first.set_value();
  });
  ASSERT_TRUE(cause_an_event(session));
  ASSERT_EQ(first.get_future().wait_for(kLong), std::future_status::ready);
  ASSERT_TRUE(cause_an_event(session));
  EXPECT_EQ(second.get_future().wait_for(kLong), std::future_status::ready);
  session.on_event({});
}

/// Makes calls until one throws. @return the text of the exception.
std::string thrown_by_calls(Session& session) {
  const auto end = std::chrono::steady_clock::now() + kLong;
  while (std::chrono::steady_clock::now() < end) {
    try {
      static_cast<void>(session.step(1, 0));
    } catch (const std::domain_error& error) {
      return error.what();
    }
  }
  return "nothing";
}

TEST(Observer, ThatThrowsReachesTheNextCallOnce) {
  const Bench bench;
  Session session = bench.session();
  session.on_event([](const Event&) {
    throw std::domain_error("of the observer of events");
  });
  {
    Session other = bench.session();
    ASSERT_TRUE(cause_an_event(other));
  }
  EXPECT_EQ(thrown_by_calls(session), "of the observer of events");
  EXPECT_TRUE(cause_an_event(session)) << "its reports have ended";
}

TEST(Observer, OfRefusalsThatThrowsReachesTheNextCallOnce) {
  const Bench bench;
  Session session = bench.session();
  session.on_set_point_refusal([](const client::SetPointRefusal&) {
    throw std::domain_error("of the observer of refusals");
  });
  std::string thrown = "nothing";
  try {
    ASSERT_TRUE(cause_a_refusal(session));
    thrown = thrown_by_calls(session);
  } catch (const std::domain_error& error) {  // the step followed the report
    thrown = error.what();
  }
  EXPECT_EQ(thrown, "of the observer of refusals");
  EXPECT_TRUE(cause_a_refusal(session)) << "its reports have ended";
}

TEST(Observer, OfEachKindThatThrowsReachesASeparateCall) {
  const Bench bench;
  Session session = bench.session();
  std::promise<void> has_begun;
  session.on_event([&](const Event&) {
    has_begun.set_value();
    throw std::domain_error("of events");
  });
  {
    Session other = bench.session();
    ASSERT_TRUE(cause_an_event(other));
  }
  ASSERT_EQ(has_begun.get_future().wait_for(kLong), std::future_status::ready);
  session.watch_services([](const client::ServiceChange&) {
    throw std::domain_error("of services");
  });
  const std::string first = thrown_by_calls(session);
  const std::string second = thrown_by_calls(session);
  EXPECT_THAT((std::array{first, second}),
              testing::UnorderedElementsAre("of events", "of services"));
}

constexpr std::array<client::AxisId, 1> kFirstAxis{{{1, 1}}};

/// Lets an observer of the status throw. @return whether its reports have ended in time.
bool fail_an_observer(Session& session) {
  std::promise<void> ended;
  auto end = ended.get_future();
  // Owned only by the observer, which is destroyed when its thread has ended.
  std::shared_ptr<void> observed(nullptr, [&ended](void*) {
    ended.set_value();
  });
  const auto reports = session.report_status(kFirstAxis, milliseconds(1),
                                             [observed = std::move(observed)](const Observation&) {
                                               throw std::domain_error("of the observer of axes");
                                             });
  return reports && end.wait_for(kLong) == std::future_status::ready;
}

/// @return the text of the exception that the call throws.
template <typename Call>
std::string thrown_by(const Call& call) {
  try {
    call();
  } catch (const std::domain_error& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Observer, ThatThrowsReachesEachCallThatNeedsABench) {
  const Bench bench;
  Session session = bench.session();
  auto follower = session.follow({{1, 1}}, client::Pace::drive);
  auto clock = StepClock::join(session, kFirst);
  ASSERT_TRUE(clock) << clock.outcome().message();
  const std::vector<std::pair<std::string, std::function<void()>>> calls{
      {"find_benches",
       [&] {
         static_cast<void>(session.find_benches());
       }},
      {"find_bench",
       [&] {
         static_cast<void>(session.find_bench());
       }},
      {"axis",
       [&] {
         static_cast<void>(session.axis("1.1"));
       }},
      {"axes",
       [&] {
         static_cast<void>(session.axes());
       }},
      {"on_status",
       [&] {
         static_cast<void>(
             session.on_status(kFirstAxis, milliseconds(1), [](const Observation&) {}));
       }},
      {"group",
       [&] {
         static_cast<void>(
             client::AxisGroup::create(session, std::array<std::string, 2>{"1.1", "1.2"}));
       }},
      {"next",
       [&] {
         static_cast<void>(follower->next(kLong));
       }},
      {"step",
       [&] {
         static_cast<void>(clock->step(1, kLong));
       }},
      {"step_for", [&] {
         static_cast<void>(clock->step_for(milliseconds(1), kLong));
       }}};
  for (const auto& [name, call] : calls) {
    ASSERT_TRUE(fail_an_observer(session)) << name;
    EXPECT_EQ(thrown_by(call), "of the observer of axes") << name;
    EXPECT_EQ(thrown_by(call), "nothing") << name << ", the second time";
  }
}

TEST(Observer, ThatThrowsKeepsNoStopFromItsAxes) {
  const Bench bench;
  Session session = bench.session();
  auto axis = session.axis("1.1").value();
  auto group = client::AxisGroup::create(session, std::array<std::string, 2>{"1.1", "1.2"}).value();
  const std::vector<std::pair<std::string, std::function<Outcome()>>> stops{
      {"halt",
       [&] {
         return axis.halt();
       }},
      {"quick_stop",
       [&] {
         return axis.quick_stop();
       }},
      {"quick_stop of the bench",
       [&] {
         return session.quick_stop(1);
       }},
      {"halt_all",
       [&] {
         return group.halt_all();
       }},
      {"quick_stop_all", [&] {
         return group.quick_stop_all();
       }}};
  for (const auto& row : stops) {
    const auto& name = row.first;
    const auto& stop = row.second;
    ASSERT_TRUE(group.enable_all()) << name;
    ASSERT_TRUE(axis.start_move(1'000'000)) << name;
    ASSERT_TRUE(session.axis("1.2")->start_move(1'000'000)) << name;
    ASSERT_TRUE(fail_an_observer(session)) << name;
    Outcome stopped;
    EXPECT_EQ(thrown_by([&] {
                stopped = stop();
              }),
              "nothing")
        << name;
    EXPECT_TRUE(stopped) << name << ": " << stopped.message();
    EXPECT_EQ(thrown_by([&] {
                static_cast<void>(session.step(1, 0));
              }),
              "of the observer of axes")
        << name;
    ASSERT_TRUE(session.quick_stop(1)) << name;
  }
  ASSERT_TRUE(fail_an_observer(session));
  EXPECT_EQ(thrown_by([&] {
              EXPECT_TRUE(group.queue_move(Eigen::VectorXd::Constant(2, 5.0)));
              EXPECT_TRUE(session.release());
            }),
            "nothing");
}

TEST(Observer, DoesNotGetWhatAnotherOneHasThrown) {
  const Bench bench;
  std::promise<bool> called;
  bool has_called = false;
  Session session = bench.session();
  ASSERT_TRUE(fail_an_observer(session));
  session.on_event([&](const Event&) {
    if (std::exchange(has_called, true)) return;
    called.set_value(session.step(1, 0) && session.axis("1.1"));
  });
  Session other = bench.session();
  ASSERT_TRUE(cause_an_event(other));
  auto result = called.get_future();
  ASSERT_EQ(result.wait_for(kLong), std::future_status::ready);
  EXPECT_TRUE(result.get());
  EXPECT_EQ(thrown_by_calls(session), "of the observer of axes");
}

TEST(Observer, ThatReplacesItsReportsEndsWithItsSession) {
  constexpr int kRounds = 100;
  const Bench bench;
  for (int round = 0; round < kRounds; ++round) {
    std::atomic<bool> has_ended = false;
    std::atomic<bool> is_late = false;
    std::promise<void> begun;
    std::once_flag begins;
    Session* its = nullptr;
    std::function<void(const Observation&)> observer = [&](const Observation&) {
      if (has_ended) is_late = true;
      std::call_once(begins, [&] {
        begun.set_value();
      });
      static_cast<void>(its->on_status(kFirstAxis, milliseconds(1), observer));
    };
    {
      Session session = bench.session();
      its = &session;
      ASSERT_TRUE(session.on_status(kFirstAxis, milliseconds(1), observer));
      ASSERT_EQ(begun.get_future().wait_for(kLong), std::future_status::ready);
    }
    has_ended = true;
    ASSERT_FALSE(is_late) << "round " << round;
  }
}

TEST(Observer, MayBeReplacedByTwoThreadsAtOnce) {
  constexpr int kRounds = 200;
  const Bench bench;
  Session session = bench.session();
  const auto replace = [&session] {
    for (int round = 0; round < kRounds; ++round) {
      session.on_event([](const Event&) {});
      session.watch_services([](const client::ServiceChange&) {});
      if (!session.on_status(kFirstAxis, milliseconds(1), [](const Observation&) {})) return false;
    }
    return true;
  };
  auto other = std::async(std::launch::async, replace);
  EXPECT_TRUE(replace());
  EXPECT_TRUE(other.get());
}

TEST(Observer, GetsNothingAfterItHasEndedItsReports) {
  const Bench first;
  const Bench second({.number = 2, .bus = first.bus()});
  std::atomic<int> states = 0;
  std::atomic<int> changes = 0;
  std::promise<void> both_ended;
  Session session = first.session();
  // Owned only by the observers, which are destroyed when their threads have ended.
  std::shared_ptr<void> observed(nullptr, [&both_ended](void*) {
    both_ended.set_value();
  });
  const std::array<client::AxisId, 2> axes{{{1, 1}, {2, 1}}};
  ASSERT_TRUE(session.on_status(axes, milliseconds(1), [&, observed](const Observation&) {
    ++states;
    static_cast<void>(session.on_status({}, milliseconds(1), {}));
  }));
  session.watch_services([&, observed = std::move(observed)](const client::ServiceChange&) {
    ++changes;
    session.watch_services({});
  });
  ASSERT_EQ(both_ended.get_future().wait_for(kLong), std::future_status::ready);
  EXPECT_EQ(states, 1) << "both benches have a state";
  EXPECT_EQ(changes, 1) << "both services are found";
}

TEST(StatusReports, MayBeDestroyedByTheirObserver) {
  const Bench bench;
  std::promise<void> destroyed;
  std::mutex mutex;
  std::optional<client::StatusReports> reports;
  Session session = bench.session();
  {
    const std::scoped_lock lock(mutex);
    reports.emplace(session
                        .report_status(kFirstAxis, milliseconds(1),
                                       [&](const Observation&) {
                                         {
                                           const std::scoped_lock own(mutex);
                                           reports.reset();
                                         }
                                         destroyed.set_value();  // would throw on a second report
                                       })
                        .value());
  }
  ASSERT_EQ(destroyed.get_future().wait_for(kLong), std::future_status::ready);
  EXPECT_TRUE(session.step(1, 3)) << "no second report has thrown";
}

// ---- reports after the call ---------------------------------------------------------------------

TEST(Events, WithoutHistoryBeginWithTheCall) {
  const Bench bench;
  Session first = bench.session();
  ASSERT_TRUE(cause_an_event(first));
  ASSERT_TRUE(first.step(1, 10));
  const std::uint64_t begin = tick_of(first);
  std::promise<std::uint64_t> seen;
  bool has_seen = false;
  Session late = bench.session();
  late.on_event([&](const Event& event) {
    if (!std::exchange(has_seen, true)) seen.set_value(event.tick);
  });
  ASSERT_TRUE(cause_an_event(first));
  auto tick = seen.get_future();
  ASSERT_EQ(tick.wait_for(kLong), std::future_status::ready);
  EXPECT_GE(tick.get(), begin);
}

TEST(StatusReports, InLockStepShowTheNewestStateToWhoComesAfterTheLastStep) {
  const Bench bench;
  Session session = bench.session();
  const std::uint64_t last = session.step(1, 7).value();
  std::promise<std::uint64_t> seen;
  bool has_seen = false;
  Session late = bench.session();
  const std::array<client::AxisId, 1> axes{{{1, 1}}};
  const auto reports = late.report_status(axes, milliseconds(1), [&](const Observation& shown) {
    if (!std::exchange(has_seen, true)) seen.set_value(shown.tick);
  });
  ASSERT_TRUE(reports);
  auto tick = seen.get_future();
  ASSERT_EQ(tick.wait_for(kLong), std::future_status::ready);
  EXPECT_EQ(tick.get(), last);
}

// A session waits for the state of a real-time bench, because only the state has its rate.
TEST(BenchState, IsThereForEachReaderThatComes) {
  const Bench bench;
  Session session = bench.session();
  for (int reader = 1; reader <= 5; ++reader) {
    ASSERT_TRUE(session.step(1, 1));
    const auto participant =
        wire::make_participant({.role = wire::Role::client, .bus = bench.bus()}, "vdrive client");
    std::atomic<int> states{0};
    const wire::Subscription<msg::BenchState> subscription(
        *participant, [&](const msg::BenchState& /*state*/, const wire::Source& /*source*/) {
          ++states;
        });
    ASSERT_TRUE(session.step(1, 1));  // much sooner than 50 ms after the last state
    EXPECT_GE(states, 1) << "reader " << reader;
  }
}

// Ten benches of each clock mode: only the first call of a session can receive an earlier sample,
// and not always.
TEST(Follow, OnABusBeginsWithTheCall) {
  for (std::size_t round = 0; round < 30; ++round) {
    const ClockMode clock =
        std::array{ClockMode::lockstep, ClockMode::realtime, ClockMode::freerun}.at(round % 3);
    const Bench bench({.clock = clock});
    Session session = bench.session();
    Session stepper = bench.session();
    auto axis = session.axis("1.1");
    ASSERT_TRUE(axis) << axis.outcome().message();
    const auto written = axis->write({0x6067, 0}, 77);
    ASSERT_TRUE(written) << to_string(clock);
    auto follower = session.follow({{1, 1}}, client::Pace::observe);
    ASSERT_TRUE(follower) << to_string(clock);
    if (clock == ClockMode::lockstep) {
      ASSERT_TRUE(stepper.step(1, 1));
    }
    const auto first = follower->next(kLong);
    ASSERT_TRUE(first) << to_string(clock) << first.outcome().message();
    EXPECT_GE(first->tick, *written) << to_string(clock);
  }
}

/// A session that has begun to receive reports of an axis.
class ReportedSession {
 public:
  explicit ReportedSession(const Bench& bench) : session_(bench.session()) {
    EXPECT_TRUE(session_.on_status(
        kAxes, milliseconds(1),
        [this](const Observation&) {
          if (!std::exchange(has_seen_, true)) seen_.set_value();
        },
        [this](const Outcome& outcome) {
          ended_.set_value(outcome);
        }));
    EXPECT_EQ(seen_.get_future().wait_for(kLong), std::future_status::ready);
  }

  [[nodiscard]] Session& session() { return session_; }

  /// @return why the reports have ended; nothing while they continue. Over DDS their end takes as
  ///         long as the session tolerates silence, 10 s.
  std::optional<Outcome> end() {
    auto outcome = ended_.get_future();
    const bool has_ended = outcome.wait_for(seconds(5)) == std::future_status::ready;
    EXPECT_TRUE(session_.on_status(kAxes, milliseconds(1), {}));
    return has_ended ? std::optional(outcome.get()) : std::nullopt;
  }

 private:
  static constexpr std::array<client::AxisId, 1> kAxes{{{1, 1}}};

  std::promise<void> seen_;
  std::promise<Outcome> ended_;
  bool has_seen_ = false;
  Session session_;
};

TEST(StatusReports, OfABenchThatEndsAreEndedAtOnce) {
  for (const ClockMode clock : {ClockMode::lockstep, ClockMode::realtime, ClockMode::freerun}) {
    std::optional<Bench> bench(std::in_place, BenchOptions{.clock = clock});
    ReportedSession reported(*bench);
    bench.reset();
    const auto outcome = reported.end();
    ASSERT_TRUE(outcome) << to_string(clock);
    EXPECT_EQ(outcome->kind(), OutcomeKind::lost);
  }
}

// A bench that replaces another is a different one, however soon it starts.
TEST(StatusReports, OfABenchThatIsReplacedAtOnceAreEnded) {
  for (const ClockMode clock : {ClockMode::lockstep, ClockMode::realtime, ClockMode::freerun}) {
    for (int count = 0; count < 20; ++count) {
      std::optional<Bench> bench(std::in_place, BenchOptions{.clock = clock});
      ReportedSession reported(*bench);
      const BenchOptions again{.clock = clock, .bus = bench->bus()};
      bench.reset();
      bench.emplace(again);
      static_cast<void>(reported.session().find_benches());
      const auto outcome = reported.end();
      ASSERT_TRUE(outcome) << to_string(clock);
      EXPECT_THAT(outcome->message(), HasSubstr("went offline: its service has ended"));
    }
  }
}

TEST(StatusReports, ShowAStateThatIsRestoredInTheSameTick) {
  const Bench bench;
  std::promise<void> enabled;
  std::promise<std::uint64_t> restored;
  bool was_enabled = false;
  bool was_restored = false;
  Session session = bench.session();
  const auto snapshot = session.take_snapshot(1);
  ASSERT_TRUE(snapshot);
  ASSERT_TRUE(session.axis("1.1")->enable());
  const std::uint64_t tick = tick_of(session);
  const auto reports =
      session.report_status(kFirstAxis, milliseconds(1), [&](const Observation& shown) {
        const bool is_enabled = shown.axes.front().state() == PowerState::operation_enabled;
        if (is_enabled && !std::exchange(was_enabled, true)) enabled.set_value();
        if (!is_enabled && !std::exchange(was_restored, true)) restored.set_value(shown.tick);
      });
  ASSERT_TRUE(reports);
  ASSERT_EQ(enabled.get_future().wait_for(kLong), std::future_status::ready);
  ASSERT_TRUE(session.restore_snapshot(1, *snapshot));
  auto seen = restored.get_future();
  ASSERT_EQ(seen.wait_for(seconds(5)), std::future_status::ready);
  EXPECT_EQ(seen.get(), tick);
}

// ---- ends --------------------------------------------------------------------------------------

/// The outcome of each call after its bench has ended, by the name of the call.
using Answers = std::vector<std::pair<std::string, Outcome>>;

Answers answers_of_session(Session& session) {
  const std::array<client::AxisId, 1> axes{{{1, 1}}};
  const std::array<std::string, 2> names{"1.1", "1.2"};
  const std::array<client::SetPointFrame, 1> frames{};
  return {
      {"find_bench", session.find_bench().outcome()},
      {"find_bench(1)", session.find_bench(1).outcome()},
      {"axis", session.axis("1.1").outcome()},
      {"axis by name", session.axis("lift").outcome()},
      {"axes", session.axes().outcome()},
      {"acquire", session.acquire(axes)},
      {"step", session.step(1, 1).outcome()},
      {"set_rate", session.set_rate(1, 1.0).outcome()},
      {"wait", session.wait(1, seconds(1)).outcome()},
      {"wait_for_tick", session.wait_for_tick(1, 1'000'000).outcome()},
      {"take_snapshot", session.take_snapshot(1).outcome()},
      {"restore_snapshot", session.restore_snapshot(1, 1).outcome()},
      {"snapshots", session.snapshots(1).outcome()},
      {"drop_snapshot", session.drop_snapshot(1, 1)},
      {"send_set_points", session.send_set_points(1, frames)},
      {"observe", session.observe(axes).outcome()},
      {"follow", session.follow({{1, 1}}, client::Pace::drive).outcome()},
      {"on_status", session.on_status(axes, milliseconds(1), [](const Observation&) {})},
      {"quick_stop", session.quick_stop(1)},
      {"join", StepClock::join(session, kFirst).outcome()},
      {"group", client::AxisGroup::create(session, names).outcome()},
  };
}

Answers answers_of_axis(Axis& axis) {
  const auto always = [](const client::AxisSnapshot&) {
    return true;
  };
  const auto never = [](const client::AxisSnapshot&) {
    return false;
  };
  return {
      {"enable", axis.enable()},
      {"disable", axis.disable()},
      {"move_to", axis.move_to(5)},
      {"start_move", axis.start_move(5).outcome()},
      {"halt", axis.halt()},
      {"resume", axis.resume()},
      {"axis.quick_stop", axis.quick_stop()},
      {"reset_fault", axis.reset_fault()},
      {"status", axis.status().outcome()},
      {"read", axis.read({0x6041, 0}).outcome()},
      {"write", axis.write({0x6067, 0}, 9).outcome()},
      {"move_by", axis.move_by(5)},
      {"home", axis.home()},
      {"run_at", axis.run_at(100)},
      {"apply_torque", axis.apply_torque(10)},
      {"jog", axis.jog(100, always)},
      {"store", axis.store()},
      {"power_cycle", axis.power_cycle()},
      {"disturb", axis.disturb(client::Disturbance::load_torque, 5).outcome()},
      {"end_disturbances", axis.end_disturbances()},
      {"restore_defaults", axis.restore_defaults()},
      {"wait_until", axis.wait_until(never, seconds(5)).outcome()},
      {"axis.acquire", axis.acquire()},
      {"take_over", axis.take_over()},
  };
}

Answers answers_of_group(client::AxisGroup& group) {
  const Eigen::VectorXd targets = Eigen::VectorXd::Constant(2, 7.0);
  return {
      {"group.status", group.status().outcome()},
      {"enable_all", group.enable_all()},
      {"disable_all", group.disable_all()},
      {"move_together", group.move_together(targets)},
      {"group.move_by", group.move_by(targets)},
      {"group.take_over", group.take_over()},
      {"queue_move", group.queue_move(targets)},
      {"wait_all", group.wait_all()},
      {"halt_all", group.halt_all()},
      {"resume_all", group.resume_all()},
      {"quick_stop_all", group.quick_stop_all()},
      {"reset_all", group.reset_all()},
      {"poll", group.poll().outcome()},
      {"monitor", group.monitor(true)},
      {"start_streaming", group.start_streaming({})},
  };
}

/// Everything that a program may hold of a bench.
struct Handles {
  explicit Handles(const Bench& bench)
      : session(bench.session()),
        axis(session.axis("1.1").value()),
        group(group_of(session)),
        follower(session.follow({{1, 1}}, client::Pace::drive).value()) {}

  static client::AxisGroup group_of(Session& session) {
    const std::array<std::string, 2> axes{"1.1", "1.2"};
    return client::AxisGroup::create(session, axes).value();
  }

  /// Makes every call once.
  [[nodiscard]] Answers answers() {
    Answers all = answers_of_session(session);
    for (auto& answer : answers_of_axis(axis)) all.push_back(std::move(answer));
    for (auto& answer : answers_of_group(group)) all.push_back(std::move(answer));
    all.emplace_back("next", follower.next(milliseconds(5)).outcome());
    return all;
  }

  Session session;
  Axis axis;
  client::AxisGroup group;
  client::Follower follower;
};

TEST(Session, ThatOutlivesItsBenchIsLostInEveryCall) {
  std::optional<Bench> bench(std::in_place);
  Handles handles(*bench);
  auto clock = StepClock::join(handles.session, kFirst);
  ASSERT_TRUE(clock);
  bench.reset();
  for (const auto& [name, outcome] : handles.answers()) {
    EXPECT_EQ(outcome.kind(), OutcomeKind::lost) << name << ": " << outcome.message();
  }
  EXPECT_EQ(clock->step(1).outcome().kind(), OutcomeKind::lost);
}

TEST(Session, ThatOutlivesItsBenchWaitsForNoName) {
  constexpr std::uint64_t kNobody = 12'345;
  std::optional<Bench> bench(std::in_place);
  Session session = bench->session();
  bench.reset();
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_FALSE(session.find_name(1, kNobody));
  EXPECT_LT(std::chrono::steady_clock::now() - begin,
            milliseconds(500));  // over a network it waits 1 s
}

TEST(Session, ThatHoldsAnAxisOfABenchThatHasEndedNamesTheReason) {
  std::optional<Bench> bench(std::in_place);
  Session session = bench->session();
  ASSERT_TRUE(session.axis("1.1")->enable());
  bench.reset();
  EXPECT_EQ(session.release().message(), "bench 1 went offline: its service has ended");
}

// In real time a bench describes itself at its next tick.
TEST(Session, OnABusNamesAllBenchesWhereOneIsNotThere) {
  for (const ClockMode clock : {ClockMode::lockstep, ClockMode::realtime, ClockMode::freerun}) {
    const Bench first({.clock = clock});
    const Bench second({.clock = clock, .number = 2, .bus = first.bus()});
    for (int count = 0; count < 20; ++count) {
      const std::string message = first.session().find_bench(7).outcome().message();
      EXPECT_TRUE(message.find("found benches 1, 2 (seen: ") != std::string::npos ||
                  (message.find("found bench 1 ") != std::string::npos &&
                   message.find(", bench 2 ") != std::string::npos))
          << message;
    }
  }
}

struct BenchInUse {
  Bench bench{BenchOptions{.axes = 8}};
  Session session = bench.session();
};

// The session releases the axis in its destructor. By then, objects that the thread created later
// have already been destroyed, such as the memory of the first message.
TEST(Bench, MayEndWithTheThreadThatMadeIt) {
  std::thread([] {
    thread_local BenchInUse in_use;
    auto axis = in_use.session.axis("1.1");
    EXPECT_TRUE(axis && axis->enable() && axis->move_to(100));
  }).join();
}

/// @param is_waiting called with another session of the bench until it returns true: the wait has
///        begun
/// @return the outcome of a wait in another thread during which the bench ended.
template <typename Wait, typename IsWaiting>
OutcomeKind end_during(const BenchOptions& options, const Wait& wait, IsWaiting is_waiting) {
  std::optional<Bench> bench(std::in_place, options);
  Session session = bench->session();
  Session other = bench->session();
  auto ended = std::async(std::launch::async, [&] {
    return wait(session).kind();
  });
  while (!is_waiting(other) && ended.wait_for(seconds(0)) != std::future_status::ready) {
    std::this_thread::yield();
  }
  bench.reset();
  if (ended.wait_for(seconds(5)) != std::future_status::ready) {
    session.interrupt();
    return OutcomeKind::timed_out;
  }
  return ended.get();
}

TEST(Bench, ThatEndsEndsTheWaitsOfOtherThreadsAtOnce) {
  const auto forever = [](Session& session) {
    return session.wait(1, std::chrono::hours(24 * 365)).outcome();
  };
  // In lock-step only the wait lets time pass.
  const auto time_passes = [](Session& other) {
    const auto seen = other.observe(kFirstAxis);
    return seen && seen->tick > 10;
  };
  for (const ClockMode clock : {ClockMode::lockstep, ClockMode::realtime, ClockMode::freerun}) {
    EXPECT_EQ(end_during({.clock = clock}, forever, time_passes), OutcomeKind::lost)
        << to_string(clock);
    std::atomic<bool> has_seen = false;
    const auto follow = [&has_seen](Session& session) {
      auto follower = session.follow({{1, 1}}, client::Pace::observe);
      if (!follower) return follower.outcome();
      while (true) {
        const auto seen = follower->next(kLong);
        if (!seen) return seen.outcome();
        has_seen = true;
      }
    };
    const auto follows = [&has_seen, clock](Session& other) {
      if (clock == ClockMode::lockstep) static_cast<void>(other.step(1, 1));
      return has_seen.load();
    };
    EXPECT_EQ(end_during({.clock = clock}, follow, follows), OutcomeKind::lost) << to_string(clock);
  }
}

TEST(Bench, EndsAConditionThatIsSlowerThanItsTicksByAnInterrupt) {
  const Bench bench({.clock = ClockMode::realtime});
  Session session = bench.session();
  Session other = bench.session();
  int calls = 0;
  const auto slow = [&](const client::AxisSnapshot& /*seen*/) {
    // Five ticks, so that from the second call on a sample is always waiting.
    EXPECT_TRUE(other.wait(1, milliseconds(5)));
    if (++calls == 3) session.interrupt();
    return calls == 100;
  };
  const auto seen = session.axis("1.1")->wait_until(slow, seconds(60));
  EXPECT_EQ(seen.outcome().kind(), OutcomeKind::failed) << seen.outcome().message();
  EXPECT_EQ(calls, 3);
}

// The bench ends while the jog starts: in the first round when another session has seen the axis
// enabled, in each further round one observation later.
TEST(Bench, ThatEndsEndsAJogAtOnce) {
  for (int looks = 0; looks < 20; ++looks) {
    const auto jog = [](Session& session) {
      auto axis = session.axis("1.1");
      if (Outcome enabled = axis->enable(); !enabled) return enabled;
      return axis->jog(1'000, [](const client::AxisSnapshot&) {
        return true;
      });
    };
    const auto has_begun = [left = looks](Session& other) mutable {
      const auto status = other.axis("1.1")->status();
      return status && status->state() == PowerState::operation_enabled && left-- == 0;
    };
    ASSERT_EQ(end_during({.clock = ClockMode::realtime}, jog, has_begun), OutcomeKind::lost)
        << "after " << looks << " looks";
  }
}

// The axis loses power in the last tick, which no wait sees.
TEST(Bench, ThatEndsIsLostToACallThatWaitsForMotion) {
  const auto run = [](Session& session) {
    auto axis = session.axis("1.1");
    if (Outcome enabled = axis->enable(); !enabled) return enabled;
    return axis->run_at(100'000, {.acceleration = 1, .call = {.timeout = std::chrono::hours(1)}});
  };
  const auto runs = [](Session& other) {
    const auto status = other.axis("1.1")->status();
    return status && status->status.velocity_demand_value != 0;
  };
  for (const ClockMode clock : {ClockMode::realtime, ClockMode::freerun}) {
    for (int round = 0; round < 10; ++round) {
      ASSERT_EQ(end_during({.clock = clock}, run, runs), OutcomeKind::lost) << to_string(clock);
    }
  }
}

/// @return whether a thread of this process sleeps in the kernel.
bool is_asleep(pid_t thread) {
  std::ifstream stat("/proc/self/task/" + std::to_string(thread) + "/stat");
  std::string text;
  std::getline(stat, text);
  const std::size_t name_end = text.rfind(')');  // the state follows the name
  return name_end != std::string::npos && text.substr(name_end, 3).ends_with('S');
}

TEST(Bench, ThatEndsEndsTheWaitForAnotherStepper) {
  std::optional<Bench> bench(std::in_place);
  Session slow = bench->session();
  const auto other = StepClock::join(slow, kFirst);
  ASSERT_TRUE(other);
  Session session = bench->session();
  std::promise<pid_t> begins;
  auto ended = std::async(std::launch::async, [&] {
    auto clock = StepClock::join(session, kFirst);
    begins.set_value(gettid());
    return clock ? clock->step(1, kLong).outcome().kind() : clock.outcome().kind();
  });
  // The thread sleeps in its step, because the other stepper never grants a tick.
  const pid_t thread = begins.get_future().get();
  const auto deadline = std::chrono::steady_clock::now() + kLong;
  while (!is_asleep(thread)) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    std::this_thread::yield();
  }
  bench.reset();
  ASSERT_EQ(ended.wait_for(seconds(5)), std::future_status::ready);
  EXPECT_EQ(ended.get(), OutcomeKind::lost);
}

// ---- resources of a bench -----------------------------------------------------------------------

std::string message_of(const BenchOptions& options) {
  try {
    const Bench bench(options);
  } catch (const BenchError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Bench, WithAStateDirectoryInUseIsRefusedByName) {
  const test::TemporaryDirectory directory;
  const BenchOptions options{.state_directory = directory.path()};
  {
    const Bench bench(options);
    EXPECT_THAT(message_of(options),
                testing::AllOf(HasSubstr(directory.path().string()),
                               HasSubstr("the parameters of bench 1 are in use"),
                               HasSubstr("process " + std::to_string(getpid()))));
  }
  EXPECT_EQ(message_of(options), "accepted");
}

/// metrics.address has no effect without metrics.port.
bool is_of_a_network(const std::string& path) {
  if (path == "metrics.address") return false;
  return path.starts_with("network.") || path.starts_with("metrics.") || path.starts_with("wire.");
}

/// @return a line that sets a key of a section to the value; empty if the configuration refuses the
///         value or it is the default.
std::string line_that_chooses(const std::string& path, const std::string& value) {
  const auto dot = path.find('.');
  std::string line = path.substr(0, dot) + ": {" + path.substr(dot + 1) + ": " + value + "}\n";
  const auto text_of = [](const std::string& configuration) {
    return service::to_yaml(service::parse_configuration(configuration, "test"));
  };
  try {
    return text_of(line) == text_of("") ? "" : line;
  } catch (const settings::ConfigurationError&) {
    return "";
  }
}

TEST(Bench, RefusesEachKeyAboutANetworkWithItsReason) {
  // A value for each type of key. A key of a new type needs one here.
  const std::array<std::string, 6> values{"1",      "65",         "true",
                                          "thread", "[10.0.0.9]", "[\"10.0.0.9:11811\"]"};
  std::size_t keys = 0;
  for (const service::ConfigurationKey& key : service::configuration_keys()) {
    if (!is_of_a_network(key.path)) continue;
    ++keys;
    std::size_t chosen = 0;
    for (const std::string& value : values) {
      const std::string line = line_that_chooses(key.path, value);
      if (line.empty()) continue;
      ++chosen;
      EXPECT_EQ(message_of({.configuration = line}),
                key.path +
                    " is a network setting, which a bench in this process does not support: remove "
                    "it, or start vdrived")
          << line;
    }
    EXPECT_GE(chosen, 1U) << "no value of the test is one of " << key.path;
  }
  EXPECT_GE(keys, 9U) << "all keys of the three sections";
}

TEST(Bench, NamesTheFileOfAKeyAboutANetwork) {
  const test::TemporaryDirectory directory;
  const auto file = directory.path() / "bench.yaml";
  std::ofstream(file) << "network: {domain: 5}\n";
  EXPECT_THAT(message_of({.configuration_file = file}),
              testing::StartsWith(file.string() + ": network.domain is a network setting"));
  EXPECT_THAT(message_of({.configuration = "clock: {period: 9 s}\n"}),
              HasSubstr("configuration:1"));
}

TEST(Bench, WithoutAStateDirectorySaysWhichOptionIsMissing) {
  const Bench bench;
  Session session = bench.session();
  auto axis = session.axis("1.1");
  const Outcome refused = axis->store();
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(),
              HasSubstr("for a bench in a process BenchOptions::state_directory"));
}

TEST(Bench, HasItsOwnIncarnation) {
  std::vector<std::uint64_t> incarnations;
  for (int count = 0; count < 20; ++count) {
    const Bench bench;
    incarnations.push_back(bench.session().find_bench().value().incarnation);
  }
  EXPECT_TRUE(std::ranges::is_sorted(incarnations, std::less_equal<>()));
}

TEST(Assert, NamesTheBenchThatTheThreadWorksFor) {
  if (!kChecksInvariants) GTEST_SKIP() << "this build has no asserts";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        const service::WorksFor bench("bench 3");
        ensure(false, "the index is inside the table");
      },
      "bench 3.*the index is inside the table");
}

// ---- fork --------------------------------------------------------------------------------------

/// Runs `child` in a forked process. @return its exit code, or 128 + the signal that ended it.
template <typename Child>
int exit_code_of(const Child& child) {
  const pid_t process = fork();
  if (process == 0) {
    alarm(20);  // ends a child that hangs by a signal
    _exit(child());
  }
  int status = 0;
  waitpid(process, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

template <typename Call>
bool throws_the_origin(const Call& call) {
  try {
    call();
  } catch (const std::exception& error) {
    return std::string(error.what()).find("from which this one was forked") != std::string::npos;
  }
  return false;
}

class ForkInAnyClock : public testing::TestWithParam<ClockMode> {};

TEST_P(ForkInAnyClock, GivesTheChildAClearErrorFromEachCallAndTheParentGoesOn) {
  const test::TemporaryDirectory directory;
  std::optional<Bench> bench(std::in_place,
                             BenchOptions{.clock = GetParam(),
                                          .state_directory = directory.path() / "state",
                                          .journal = directory.path() / "journal"});
  std::optional<Handles> handles(std::in_place, *bench);
  auto reports = handles->session.report_status(std::array<client::AxisId, 1>{{{1, 1}}},
                                                milliseconds(1), [](const Observation&) {});
  ASSERT_TRUE(reports);
  handles->session.on_event([](const Event&) {});
  ASSERT_TRUE(handles->axis.enable());
  const int code = exit_code_of([&] {
    int wrong = 0;
    for (const auto& [name, outcome] : handles->answers()) {
      if (outcome.kind() == OutcomeKind::lost &&
          outcome.message().find("from which this one was forked") != std::string::npos) {
        continue;
      }
      std::fprintf(stderr, "%s: %s\n", name.c_str(), outcome.message().c_str());
      ++wrong;
    }
    wrong += throws_the_origin([&] {
      static_cast<void>(bench->session());
    })
                 ? 0
                 : 1;
    wrong += throws_the_origin([&] {
      static_cast<void>(bench->bus());
    })
                 ? 0
                 : 1;
    wrong += throws_the_origin([&] {
      handles->session.on_event({});
    })
                 ? 0
                 : 1;
    handles->session.interrupt();
    reports = Outcome::failed("ended");
    handles.reset();
    bench.reset();
    return wrong;
  });
  EXPECT_EQ(code, 0);
  const Outcome moved = handles->axis.move_to(1'000);
  EXPECT_TRUE(moved) << moved.message();
  EXPECT_TRUE(handles->axis.store());
}

INSTANTIATE_TEST_SUITE_P(EachClock, ForkInAnyClock,
                         testing::Values(ClockMode::lockstep, ClockMode::realtime),
                         [](const auto& clock) {
                           return std::string(to_string(clock.param));
                         });

TEST(Fork, LeavesTheChildFreeToMakeItsOwnBench) {
  const Bench bench;
  Session session = bench.session();
  ASSERT_TRUE(session.step(1, 3));
  EXPECT_EQ(exit_code_of([] {
              const Bench own;
              Session its = own.session();
              auto axis = its.axis("1.1");
              return axis && axis->enable() && axis->move_to(100) ? 0 : 1;
            }),
            0);
  EXPECT_TRUE(session.step(1, 3));
}

TEST(Fork, RefusesABenchOfTheChildOnTheBusOfTheParent) {
  const Bench bench;
  const auto bus = bench.bus();
  EXPECT_EQ(exit_code_of([&] {
              return message_of({.number = 2, .bus = bus}).find("from which this one was forked") !=
                             std::string::npos
                         ? 0
                         : 1;
            }),
            0);
}

// Another thread of the parent may hold the locks of the bus at the time of the fork.
TEST(Fork, LetsTheChildAbandonASessionThatItInherited) {
  const Bench bench;
  Session session = bench.session();
  Session busy = bench.session();
  std::atomic<bool> ends{false};
  std::thread abandons([&] {
    while (!ends) busy.abandon();
  });
  int failures = 0;
  for (int count = 0; count < 200 && failures == 0; ++count) {
    failures += exit_code_of([&] {
                  session.abandon();
                  return 0;
                }) == 0
                    ? 0
                    : 1;
  }
  ends = true;
  abandons.join();
  EXPECT_EQ(failures, 0);
}

TEST(Fork, LeavesTheLocksOfTheParentToTheParent) {
  const test::TemporaryDirectory directory;
  const BenchOptions options{.state_directory = directory.path()};
  std::optional<Bench> bench(std::in_place, options);
  std::array<int, 2> gate{};
  ASSERT_EQ(pipe(gate.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    close(gate[1]);
    char byte = 0;
    _exit(read(gate[0], &byte, 1) == 0 ? 0 : 1);  // lives until the parent closes its end
  }
  bench.reset();
  EXPECT_EQ(message_of(options), "accepted") << "the child still has the file open";
  close(gate[1]);
  close(gate[0]);
  waitpid(child, nullptr, 0);
}

// The processes of a pool may outlive their parent when it is killed.
TEST(Fork, GivesTheChildNoLockOfAParentThatWasKilled) {
  const test::TemporaryDirectory directory;
  const BenchOptions options{.state_directory = directory.path() / "state",
                             .journal = directory.path() / "journal"};
  std::array<int, 2> gate{};
  ASSERT_EQ(pipe(gate.data()), 0);
  const pid_t parent = fork();
  if (parent == 0) {
    close(gate[1]);
    std::array<int, 2> begun{};
    if (pipe(begun.data()) != 0) _exit(1);
    const Bench bench(options);
    char byte = 0;
    if (fork() == 0) {
      close(begun[1]);
      _exit(read(gate[0], &byte, 1) == 0 ? 0 : 1);  // lives until the test closes its end
    }
    close(begun[1]);
    static_cast<void>(read(begun[0], &byte, 1));  // until the child runs
    raise(SIGKILL);
  }
  waitpid(parent, nullptr, 0);
  EXPECT_EQ(message_of({.state_directory = options.state_directory}), "accepted");
  EXPECT_THAT(message_of({.journal = options.journal}), HasSubstr("is not empty"));
  close(gate[1]);
  close(gate[0]);
}

}  // namespace
}  // namespace vdrive::bench

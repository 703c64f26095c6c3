// SPDX-License-Identifier: Apache-2.0
// The services that a session finds: real ones, and a participant that has no bench yet.
#include "client/session_options.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <future>
#include <string>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options;
using test::RunningService;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

SessionOptions hasty() {
  SessionOptions hasty = options();
  hasty.find_timeout = 300ms;
  return hasty;
}

TEST(Discovery, FindsNoBenchWithinItsTime) {
  Session sut(hasty());
  EXPECT_THAT(sut.find_benches(), IsEmpty());
  const std::string domain = std::to_string(test::test_domain());
  const std::string place = " on domain " + domain + ", loopback only";
  const std::string advice = "; next step: vdrive --domain " + domain + " doctor";
  EXPECT_THAT(sut.no_bench_found().message(),
              AllOf(StartsWith("no bench was found" + place + " (seen: no other participant"),
                    EndsWith(advice)));
  EXPECT_THAT(sut.find_bench(7).outcome().message(),
              AllOf(StartsWith("no bench 7" + place), EndsWith(advice)));
  EXPECT_THAT(sut.axis("some").outcome().message(), AllOf(HasSubstr(place), EndsWith(advice)));
  const auto axis = sut.axis("1.1");
  EXPECT_EQ(axis.outcome().kind(), OutcomeKind::not_found);
  EXPECT_THAT(axis.outcome().message(), HasSubstr("1.1"));
  EXPECT_THAT(axis.outcome().message(), HasSubstr("no bench was found"));
}

TEST(Discovery, NamesTheBenchAndTheInterfacesThatItLookedFor) {
  SessionOptions one = hasty();
  one.bench = 7;
  one.interfaces = {"127.0.0.1"};
  Session sut(one);
  EXPECT_THAT(sut.find_benches(), IsEmpty());
  const std::string domain = std::to_string(test::test_domain());
  EXPECT_THAT(
      sut.no_bench_found().message(),
      AllOf(StartsWith("bench 7 was not found on domain " + domain +
                       ", interfaces 127.0.0.1 (seen: "),
            EndsWith("; next step: vdrive --domain " + domain + " --interface 127.0.0.1 doctor")));
}

/// A participant of a service that describes its bench only after SIGUSR1.
class MuteService {
 public:
  MuteService()
      : process_(VDRIVE_WIRE_DOUBLE,
                 {std::to_string(test::test_domain()), "1000", "0", "vdrived 1"}) {
    EXPECT_EQ(process_.read_line(), "ready");
  }

  void describe() const { process_.send(SIGUSR1); }

 private:
  test::Process process_;
};

TEST(Discovery, WaitsForAServiceThatHasAnnouncedItself) {
  const MuteService service;
  SessionOptions brief = options();
  brief.find_timeout = 2s;
  Session sut(brief);
  auto found = std::async(std::launch::async, [&] {
    return sut.find_bench(1);
  });
  EXPECT_EQ(found.wait_for(brief.find_timeout + 500ms), std::future_status::timeout);
  service.describe();
  const auto bench = found.get();
  EXPECT_TRUE(bench) << bench.outcome().message();
}

TEST(Discovery, SaysWhatItSawWhenNoBenchIsFound) {
  const MuteService service;
  SessionOptions brief = options();
  brief.find_timeout = 1s;
  Session sut(brief);
  const auto seen =
      HasSubstr("seen: 1 other participant, 1 service that has not described its bench");
  EXPECT_THAT(sut.find_bench().outcome().message(), seen);
  EXPECT_THAT(sut.no_bench_found().message(), seen);
  EXPECT_THAT(sut.find_bench(1).outcome().message(), seen);
  EXPECT_THAT(sut.axis("some").outcome().message(), seen);
  EXPECT_THAT(sut.find_bench(2).outcome().message(), HasSubstr("seen: 1 other participant"));
}

TEST(Discovery, NamesTheBenchesThatAreThereWhereTheOnlyOneThatItFindsIsNot) {
  const MuteService service;
  SessionOptions one = options();
  one.find_timeout = 1s;
  one.bench = 9;
  Session sut(one);
  const std::string place = " on domain " + std::to_string(test::test_domain());
  const std::string others = place + ", found bench 1 (seen: 1 other participant";
  EXPECT_THAT(sut.find_bench().outcome().message(), StartsWith("no bench 9" + others));
  EXPECT_THAT(sut.no_bench_found().message(), StartsWith("bench 9 was not found" + others));
  EXPECT_THAT(sut.axis("some").outcome().message(), HasSubstr(others));
}

TEST(Discovery, RefusesADomainOutOfRange) {
  SessionOptions wrong;
  wrong.domain = 233;
  EXPECT_THROW(Session{wrong}, std::runtime_error);
}

TEST(Discovery, FindsBenchesAxesAndNames) {
  const RunningService first("--clock lockstep");
  const RunningService second("--clock realtime --bench 7 --axes 3");
  Session sut(options());
  const auto deadline = std::chrono::steady_clock::now() + 10s;
  auto benches = sut.find_benches();
  while (benches.size() < 2 && std::chrono::steady_clock::now() < deadline) {
    benches = sut.find_benches();
  }
  ASSERT_THAT(benches, SizeIs(2));
  EXPECT_EQ(benches[0].clock_mode, ClockMode::lockstep);
  EXPECT_EQ(benches[1].number, 7U);
  EXPECT_THAT(benches[1].axes, SizeIs(3));
  EXPECT_EQ(sut.axis("7.3")->id(), (AxisId{7, 3}));
  const std::string name = benches[0].axes[0].name;
  EXPECT_EQ(sut.axis(name).outcome().message(), "") << name;
  EXPECT_THAT(sut.axis("7.4").outcome().message(), HasSubstr("bench 7"));
  EXPECT_EQ(sut.axis("nobody").outcome().kind(), OutcomeKind::not_found);
  EXPECT_EQ(sut.find_bench().outcome().kind(), OutcomeKind::not_found) << "several are there";
  EXPECT_TRUE(sut.find_bench(7));
}

// A search for further benches takes 150 ms.
TEST(Discovery, FindsANameAsSoonAsItsBenchAnswers) {
  const RunningService service("--clock lockstep");
  std::string name;
  {
    Session known(options());
    name = known.find_bench()->axes[0].name;
  }
  const auto deadline = std::chrono::steady_clock::now() + 30s;
  auto shortest = std::chrono::steady_clock::duration::max();
  while (shortest >= 150ms) {  // long on a busy machine
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    Session sut(options());
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_TRUE(sut.axis(name));
    shortest = std::min(shortest, std::chrono::steady_clock::now() - begin);
  }
}

TEST(Discovery, DropsAKilledServiceFromTheList) {
  RunningService service("--clock lockstep");
  SessionOptions patient = options();
  patient.find_timeout = 3s;
  Session sut(patient);
  ASSERT_THAT(sut.find_benches(), SizeIs(1));
  service.kill();
  const auto gone = std::chrono::steady_clock::now() + 10s;
  while (!sut.find_benches().empty()) ASSERT_LT(std::chrono::steady_clock::now(), gone);
}

}  // namespace
}  // namespace vdrive::client

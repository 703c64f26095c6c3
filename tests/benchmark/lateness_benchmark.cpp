// SPDX-License-Identifier: Apache-2.0
//
// How late the ticks of a realtime bench begin and, over the same time, how late a bare loop wakes
// that sleeps until each millisecond with clock_nanosleep.
//
//   vdrive_lateness_benchmark VDRIVED SECONDS CLIENTS PRIORITY [argument of vdrived...]
//
// Each client is a process with a session that follows all axes of bench 1. PRIORITY is that of
// SCHED_FIFO for bench and loop; 0 = normal scheduling. If that is not permitted, nothing is
// measured.
//
// A bench counts its ticks in bins of powers of two. A quantile is interpolated within its bin as
// if the logarithms of the lateness were spread evenly. The bare loop counts in the same way, so
// both are comparable. Prints JSON lines: {"figure":"late_us_p99","clients":4,"priority":0,...}.
#include "bare_node.hpp"
#include "service_process.hpp"
#include "support/test_domain.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace {

using namespace vdrive;
using namespace std::chrono_literals;

constexpr std::size_t kBins = 32;

/// Counts of ticks by lateness; bin i: below 2^i us.
using Histogram = std::array<std::uint64_t, kBins>;

struct Settings {
  std::string program;
  std::chrono::seconds duration{};
  int clients = 0;
  int priority = 0;
};

bool may_have(int priority) {
  bool permitted = false;
  std::thread([&] {
    const sched_param parameters{.sched_priority = priority};
    permitted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
  }).join();
  return permitted;
}

/// @return the lateness that the fraction `share` of the ticks does not exceed [us].
double quantile(const Histogram& histogram, double share) {
  std::uint64_t all = 0;
  for (const std::uint64_t count : histogram) all += count;
  double left = share * static_cast<double>(all);
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const auto count = static_cast<double>(histogram.at(bin));
    if (left <= count && count > 0.0) {
      return std::exp2(static_cast<double>(bin) - 1.0 + left / count);
    }
    left -= count;
  }
  return std::exp2(static_cast<double>(kBins));
}

Histogram difference(Histogram later, const Histogram& earlier) {
  for (std::size_t bin = 0; bin < kBins; ++bin) later.at(bin) -= earlier.at(bin);
  return later;
}

/// Sleeps until each millisecond, from its construction until `end`.
class BareLoop {
 public:
  explicit BareLoop(int priority)
      : thread_([this, priority] {
          run(priority);
        }) {}

  ~BareLoop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  BareLoop(const BareLoop&) = delete;
  BareLoop& operator=(const BareLoop&) = delete;

  [[nodiscard]] Histogram end() {
    stop_ = true;
    thread_.join();
    return late_;
  }

 private:
  void run(int priority) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    constexpr std::int64_t kMillisecond = 1'000'000;
    prctl(PR_SET_TIMERSLACK, 1UL);
    const sched_param parameters{.sched_priority = priority};
    if (priority != 0) pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
    timespec wall{};
    clock_gettime(CLOCK_REALTIME, &wall);
    timespec next{};
    clock_gettime(CLOCK_MONOTONIC, &next);
    // Halfway between two ticks of the bench, which begin at the milliseconds of the wall clock.
    next.tv_nsec += 2 * kMillisecond + kMillisecond / 2 - wall.tv_nsec % kMillisecond;
    while (!stop_) {
      if (next.tv_nsec >= kSecond) {
        next.tv_nsec -= kSecond;
        ++next.tv_sec;
      }
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
      timespec now{};
      clock_gettime(CLOCK_MONOTONIC, &now);
      const std::int64_t late = (now.tv_sec - next.tv_sec) * kSecond + (now.tv_nsec - next.tv_nsec);
      const auto microseconds = static_cast<std::uint64_t>(std::max<std::int64_t>(late, 0)) / 1'000;
      ++late_.at(std::min<std::size_t>(std::bit_width(microseconds), kBins - 1));
      next.tv_nsec += kMillisecond;
    }
  }

  std::atomic<bool> stop_{false};
  Histogram late_{};
  std::thread thread_;
};

/// Collects the counters of the bench.
class States {
 public:
  States()
      : participant_(wire::make_participant(
            {.domain = test::test_domain(), .role = wire::Role::client}, "benchmark")),
        states_(*participant_, [this](const msg::BenchState& state, const wire::Source&) {
          const std::lock_guard lock(mutex_);
          const auto& bins = state.lateness_histogram;
          std::copy_n(bins.begin(), std::min(bins.size(), kBins), late_.begin());
          has_arrived_ = true;
        }) {}

  [[nodiscard]] bool has_arrived() {
    const std::lock_guard lock(mutex_);
    return has_arrived_;
  }

  [[nodiscard]] Histogram late() {
    const std::lock_guard lock(mutex_);
    return late_;
  }

 private:
  std::mutex mutex_;
  Histogram late_{};
  bool has_arrived_ = false;
  std::unique_ptr<wire::Participant> participant_;
  wire::Subscription<msg::BenchState> states_;
};

/// A client that receives every status of all axes.
/// @param joined counts the clients that have received a first status
void follow(std::chrono::seconds duration, std::atomic<int>& joined) {
  client::Session session({.domain = test::test_domain(), .bench = 1, .find_timeout = 30s});
  const auto bench = session.find_bench(1);
  if (!bench) throw std::runtime_error(bench.outcome().message());
  std::vector<client::AxisId> axes;
  for (const auto& axis : bench->axes) axes.push_back(axis.id);
  auto follower = session.follow(std::move(axes), client::Pace::observe);
  if (!follower) throw std::runtime_error(follower.outcome().message());
  const auto end = std::chrono::steady_clock::now() + duration;
  if (!follower->next(30s)) return;
  ++joined;
  while (std::chrono::steady_clock::now() < end && follower->next(1s)) {
  }
}

/// @throws std::runtime_error if the condition does not become true within a minute
template <typename Condition>
void expect_soon(const Condition& condition, const std::string& missing) {
  if (!bare::wait_until(condition, 60s)) throw std::runtime_error(missing);
}

void print(const Settings& settings, const std::string& figure, const Histogram& histogram) {
  std::size_t last = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    if (histogram.at(bin) != 0) last = bin;
  }
  const auto line = [&](const std::string& name, double value) {
    std::cout << R"({"figure":")" << figure << name << R"(","clients":)" << settings.clients
              << R"(,"priority":)" << settings.priority << R"(,"value":)" << value << "}\n";
  };
  line("_us_p50", quantile(histogram, 0.5));
  line("_us_p99", quantile(histogram, 0.99));
  line("_us_p99.9", quantile(histogram, 0.999));
  line("_us_max_below", std::exp2(static_cast<double>(last)));
}

int run(const Settings& settings, std::vector<std::string> arguments) {
  if (settings.priority != 0 && !may_have(settings.priority)) {
    std::cerr << "SCHED_FIFO is not permitted: nothing measured\n";
    return 0;
  }
  static_cast<void>(test::test_domain());  // the other processes use the same domain
  const auto file = std::filesystem::temp_directory_path() /
                    ("vdrive-lateness-" + std::to_string(getpid()) + ".yaml");
  std::ofstream(file) << "clock:\n  realtime_priority: " << settings.priority << '\n';
  arguments.insert(arguments.end(), {"--config", file.string()});
  const test::ServiceProcess service(settings.program, std::move(arguments));
  auto& joined = bare::shared_with_partners<std::atomic<int>>();
  std::vector<std::unique_ptr<bare::Partner>> clients;
  for (int count = 0; count < settings.clients; ++count) {
    clients.push_back(std::make_unique<bare::Partner>([&] {
      follow(settings.duration + 60s, joined);
    }));
  }
  States states;
  expect_soon(
      [&] {
        return states.has_arrived();
      },
      "no bench 1");
  std::filesystem::remove(file);
  expect_soon(
      [&] {
        return joined == settings.clients;
      },
      "not every client receives status");
  const Histogram before = states.late();
  BareLoop loop(settings.priority);
  std::this_thread::sleep_for(settings.duration);
  const Histogram bare = loop.end();
  print(settings, "late", difference(states.late(), before));
  print(settings, "bare_late", bare);
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  constexpr int kFirst = 5;
  if (count < kFirst) {
    std::cerr << "usage: vdrive_lateness_benchmark VDRIVED SECONDS CLIENTS PRIORITY "
                 "[argument...]\n";
    return 2;
  }
  try {
    return run({.program = arguments[1],
                .duration = std::chrono::seconds(std::stoi(arguments[2])),
                .clients = std::stoi(arguments[3]),
                .priority = std::stoi(arguments[4])},
               {arguments + kFirst, arguments + count});
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}

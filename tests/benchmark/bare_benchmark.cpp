// SPDX-License-Identifier: Apache-2.0
// The cost of the DDS library and the kernel alone, to which other figures are compared.
//
//   vdrive_bare_benchmark round-trip COUNT
//       a reliable request and its reply between two processes, passed from the listener to a
//       worker on both sides, with the sizes and the QoS of a step of one tick
//   vdrive_bare_benchmark sleep SECONDS
//       how late a thread wakes that sleeps until each millisecond
//
// Prints JSON lines: {"figure":"bare_round_trip_us_p50","value":...}.
#include "bare_node.hpp"
#include "support/test_domain.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace vdrive::bare;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kRequest = 92;  // a step that names no axes
constexpr std::size_t kReply = 92;    // its reply

/// Passes samples from the listener's thread to another thread.
class Mailbox {
 public:
  void put(const Bytes& bytes) {
    {
      const std::scoped_lock lock(mutex_);
      bytes_ = bytes;
      ++count_;
    }
    changed_.notify_one();
  }

  /// @return false if fewer than `count` samples have arrived by then.
  bool wait_for(std::uint64_t count, std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, patience, [&] {
      return count_ >= count;
    });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  Bytes bytes_;
  std::uint64_t count_ = 0;
};

double microseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

/// The partner process: replies to each request.
[[noreturn]] void answer(std::uint32_t domain) {
  Mailbox mailbox;
  Listener listener([&mailbox](const Bytes& sample) {
    mailbox.put(sample);
  });
  Node node(domain);
  auto& writer = node.writer("reply", true);
  // A client may send as soon as it finds the reader of requests, so that reader is created only
  // after the replies are matched.
  if (!wait_for_reader(writer)) std::_Exit(1);
  node.read("request", true, listener);
  Bytes reply(kReply);
  for (std::uint64_t number = 1; true; ++number) {
    while (!mailbox.wait_for(number, 1s)) {
    }
    writer.write(&reply);
  }
}

int go_round(int count) {
  const std::uint32_t domain = vdrive::test::test_domain();
  const Partner partner([domain] {
    answer(domain);
  });
  Mailbox mailbox;
  Listener listener([&mailbox](const Bytes& sample) {
    mailbox.put(sample);
  });
  Node node(domain);
  auto& writer = node.writer("request", true);
  node.read("reply", true, listener);
  if (!wait_for_reader(writer)) return 1;
  Bytes request(kRequest);
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(count));
  const auto begin = Clock::now();
  for (int number = 1; number <= count; ++number) {
    const auto sent = Clock::now();
    const bool is_sent = vdrive::wire::write_to(writer, &request);
    if (!is_sent || !mailbox.wait_for(static_cast<std::uint64_t>(number), 10s)) {
      std::cerr << (is_sent ? "no reply to request " : "the library does not take request ")
                << number << '\n';
      return 1;
    }
    times.push_back(microseconds_since(sent));
  }
  print_figure("bare_round_trips_per_second", count * 1e6 / microseconds_since(begin));
  std::sort(times.begin(), times.end());
  print_figure("bare_round_trip_us_p50", quantile(times, 0.5));
  print_figure("bare_round_trip_us_p99", quantile(times, 0.99));
  return 0;
}

int sleep_and_wake(int seconds) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  prctl(PR_SET_TIMERSLACK, 1UL);
  std::vector<double> late;
  timespec next{};
  clock_gettime(CLOCK_MONOTONIC, &next);
  for (int tick = 0; tick < seconds * 1'000; ++tick) {
    next.tv_nsec += 1'000'000;
    if (next.tv_nsec >= kSecond) {
      next.tv_nsec -= kSecond;
      ++next.tv_sec;
    }
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    late.push_back(1e6 * static_cast<double>(now.tv_sec - next.tv_sec) +
                   1e-3 * static_cast<double>(now.tv_nsec - next.tv_nsec));
  }
  std::sort(late.begin(), late.end());
  print_figure("bare_late_us_p50", quantile(late, 0.5));
  print_figure("bare_late_us_p99", quantile(late, 0.99));
  print_figure("bare_late_us_p99.9", quantile(late, 0.999));
  print_figure("bare_late_us_max", late.back());
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + count);
  try {
    if (words.size() == 2 && words[0] == "round-trip") return go_round(std::stoi(words[1]));
    if (words.size() == 2 && words[0] == "sleep") return sleep_and_wake(std::stoi(words[1]));
  } catch (const std::logic_error&) {  // not a number
  }
  std::cerr << "usage: vdrive_bare_benchmark round-trip COUNT | sleep SECONDS\n";
  return 2;
}

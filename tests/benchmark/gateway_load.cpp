// SPDX-License-Identifier: Apache-2.0
//
// Clients of a gateway that receive the status of bench 1, each in its own thread.
//
//   gateway_load PORT CLIENTS SECONDS [--deaf]
//
// Prints one line of JSON: messages per client and second, their size, and the age of a tick when
// its message arrives, for which the bench must run in real time on this machine. --deaf: the
// clients subscribe and then read nothing.
#include "gateway/tool_client.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace {

using namespace vdrive::test;
using Clock = std::chrono::system_clock;  // a realtime bench counts ticks from its epoch

struct Arguments {
  std::uint16_t port = 0;
  std::size_t clients = 0;
  std::chrono::seconds duration{};
  bool is_deaf = false;
};

/// The messages that the clients received.
class Results {
 public:
  void add(const std::vector<double>& ages, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    ages_.insert(ages_.end(), ages.begin(), ages.end());
    bytes_ += bytes;
  }

  void print(const Arguments& arguments) {
    std::ranges::sort(ages_);
    if (ages_.empty()) throw std::runtime_error("no message came");
    const double seconds =
        static_cast<double>(arguments.duration.count()) * static_cast<double>(arguments.clients);
    const auto age_at = [&](double part) {
      return ages_[static_cast<std::size_t>(part * static_cast<double>(ages_.size() - 1))];
    };
    std::cout << Json({{"clients", arguments.clients},
                       {"messages_per_second", static_cast<double>(ages_.size()) / seconds},
                       {"bytes_per_message", bytes_ / ages_.size()},
                       {"age_p50_ms", age_at(0.5)},
                       {"age_p99_ms", age_at(0.99)},
                       {"age_max_ms", ages_.back()}})
              << '\n';
  }

 private:
  std::mutex mutex_;
  std::vector<double> ages_;  ///< [ms]
  std::size_t bytes_ = 0;
};

void receive(const Arguments& arguments, Results& results) {
  ToolClient client(arguments.port);
  client.subscribe("/bench1/status");
  (void)client.next("/bench1/status");
  const auto end = Clock::now() + arguments.duration;
  if (arguments.is_deaf) {
    std::this_thread::sleep_until(end);
    return;
  }
  std::vector<double> ages;
  std::size_t bytes = 0;
  while (Clock::now() < end) {
    const ChannelMessage message = client.next("/bench1/status");
    const std::chrono::nanoseconds time(message.time);
    ages.push_back(
        std::chrono::duration<double, std::milli>(Clock::now().time_since_epoch() - time).count());
    bytes += message.payload.size();
  }
  results.add(ages, bytes);
}

Arguments parse(const std::vector<std::string_view>& words) {
  if (words.size() < 3)
    throw std::runtime_error("usage: gateway_load PORT CLIENTS SECONDS [--deaf]");
  const auto port = vdrive::parse_digits<std::uint16_t>(words[0]);
  const auto clients = vdrive::parse_digits<std::size_t>(words[1]);
  const auto seconds = vdrive::parse_digits<int>(words[2]);
  if (!port || !clients || !seconds) throw std::runtime_error("PORT, CLIENTS, SECONDS: numbers");
  return {.port = *port,
          .clients = *clients,
          .duration = std::chrono::seconds(*seconds),
          .is_deaf = words.size() > 3 && words[3] == "--deaf"};
}

void run(const Arguments& arguments) {
  Results results;
  std::vector<std::thread> threads;
  threads.reserve(arguments.clients);
  for (std::size_t i = 0; i < arguments.clients; ++i) {
    threads.emplace_back([&] {
      receive(arguments, results);
    });
  }
  for (std::thread& thread : threads) thread.join();
  if (!arguments.is_deaf) results.print(arguments);
}

}  // namespace

int main(int count, char** words) {
  try {
    run(parse({words + 1, words + count}));
  } catch (const std::exception& error) {
    std::cerr << "gateway_load: " << error.what() << '\n';
    return 1;
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
//
// Acts as bench 1 for a client, as a process that tests can kill:
//
//   wire_double DOMAIN INCARNATION ANSWER [NAME]
//
// Prints a line for each request and answers a read with ANSWER; ANSWER 0 = no answer. With NAME
// its participant has this name; it prints "ready" and describes its bench only after SIGUSR1.
#include "bench_messages.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <deque>
#include <iostream>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kBench = 1;

msg::Reply reply_to(const msg::Request& request, std::uint64_t incarnation, std::int64_t value) {
  msg::Reply reply;
  reply.client = request.client;
  reply.request_id = request.request_id;
  reply.bench = kBench;
  reply.incarnation = incarnation;
  for (const msg::ObjectAccess& object : request.objects) {
    msg::ObjectResult& result = reply.objects.emplace_back();
    result.axis = object.axis;
    result.index = object.index;
    result.value = value;
  }
  return reply;
}

/// Blocks the signal that a double without a bench waits for; must be called before the library
/// starts a thread.
sigset_t block_signal_to_describe() {
  sigset_t signals{};
  sigemptyset(&signals);
  sigaddset(&signals, SIGUSR1);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

[[noreturn]] void run(std::uint32_t domain, std::uint64_t incarnation, std::int64_t answer,
                      const std::string& name) {
  const sigset_t to_describe = block_signal_to_describe();
  std::mutex mutex;
  std::condition_variable arrived;
  std::deque<std::pair<msg::Request, wire::Source>> requests;
  const auto participant =
      wire::make_participant({.domain = domain}, name.empty() ? "wire double" : name);
  wire::Publication<msg::Reply> replies(*participant);
  wire::Publication<msg::CommandReply> command_replies(*participant);
  wire::Publication<msg::BenchState> states(*participant);
  wire::Publication<msg::BenchDescription> descriptions(*participant);
  const wire::Subscription<msg::CommandFrame> frames(
      *participant, [](const msg::CommandFrame& /*frame*/, const wire::Source& /*source*/) {});
  const wire::Subscription<msg::Request> reader(
      *participant, [&](const msg::Request& request, const wire::Source& source) {
        const std::scoped_lock lock(mutex);
        requests.emplace_back(request, source);
        arrived.notify_one();
      });
  if (!name.empty()) {
    std::cout << "ready" << std::endl;  // NOLINT(*-avoid-endl)
    int signal = 0;
    sigwait(&to_describe, &signal);
  }
  (void)descriptions.write(description(kBench, incarnation));
  while (true) {
    (void)states.write(state(kBench, incarnation));
    std::unique_lock lock(mutex);
    arrived.wait_for(lock, 50ms, [&] {
      return !requests.empty();
    });
    for (; !requests.empty(); requests.pop_front()) {
      const auto& [request, source] = requests.front();
      std::cout << "received " << request.request_id << std::endl;  // NOLINT(*-avoid-endl)
      if (answer == 0) continue;
      (void)replies.wait_for_match(source, 1s);
      (void)replies.write(reply_to(request, incarnation, answer));
    }
  }
}

}  // namespace
}  // namespace vdrive::client

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv, argv + argc);
  vdrive::client::run(static_cast<std::uint32_t>(std::stoul(arguments.at(1))),
                      std::stoull(arguments.at(2)), std::stoll(arguments.at(3)),
                      arguments.size() > 4 ? arguments[4] : "");
}

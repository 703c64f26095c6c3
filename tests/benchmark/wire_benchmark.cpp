// SPDX-License-Identifier: Apache-2.0
// The time between a client and a bench, which is a given vdrived in a separate process.
//
//   vdrive_wire_benchmark VDRIVED step|command|publish [argument of vdrived...]
//
// step     lock-step: one-tick steps, each of which waits for its reply
// command  realtime: from a command frame to the first status that shows it
// publish  realtime: processor time of the service per axis and published tick
//
// Prints JSON lines: {"figure":"step_us_p50","value":...}. To compare two trees, run the programs
// of both with the same arguments in turn.
#include "service_process.hpp"
#include "support/test_domain.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <iostream>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace vdrive;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kSession = 0x5E55104;
constexpr int kSteps = 20'000;
constexpr int kCommands = 2'000;
constexpr auto kPublishing = 10s;

class Client {
 public:
  Client()
      : participant_(wire::make_participant(
            {.domain = test::test_domain(), .role = wire::Role::client}, "vdrive client")),
        requests_(*participant_),
        frames_(*participant_),
        replies_(*participant_,
                 [this](const msg::Reply& reply, const wire::Source&) {
                   if (reply.client != kSession) return;
                   {
                     const std::lock_guard lock(mutex_);
                     reply_ = reply;
                   }
                   changed_.notify_all();  // without the lock, as in the bare program
                 }),
        command_replies_(*participant_, [](const msg::CommandReply&, const wire::Source&) {}),
        descriptions_(*participant_,
                      [this](const msg::BenchDescription& bench, const wire::Source& source) {
                        const std::lock_guard lock(mutex_);
                        bench_ = source;
                        incarnation_ = bench.incarnation;
                        changed_.notify_all();
                      }) {}

  bool find() {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, 10s, [this] {
          return bench_.has_value();
        })) {
      return false;
    }
    lock.unlock();
    return requests_.wait_for_match(*bench_, 5s) && frames_.wait_for_match(*bench_, 5s) &&
           replies_.wait_for_match(*bench_, 5s);
  }

  msg::Reply exchange(msg::Request request) {
    request.client = kSession;
    request.session = kSession;
    request.bench = 1;
    request.request_id = ++last_request_;
    static_cast<void>(requests_.write(request));
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, 10s, [this] {
          return reply_ && reply_->request_id == last_request_;
        })) {
      std::cerr << "no reply\n";
      std::exit(1);
    }
    return *reply_;
  }

  void send(std::uint32_t epoch, std::uint64_t sequence) {
    msg::CommandFrame frame;
    frame.bench = 1;
    frame.incarnation = incarnation_;
    frame.session = kSession;
    frame.epoch = epoch;
    frame.sequence_number = sequence;
    auto& command = frame.axes.emplace_back();
    command.axis = 1;
    command.members = msg::HAS_PROFILE_VELOCITY;
    command.profile_velocity = static_cast<std::uint32_t>(1'000 + sequence % 10);
    static_cast<void>(frames_.write(frame));
  }

  [[nodiscard]] wire::Participant& participant() { return *participant_; }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<msg::Reply> reply_;
  std::optional<wire::Source> bench_;
  std::uint64_t incarnation_ = 0;
  std::uint64_t last_request_ = 0;
  std::unique_ptr<wire::Participant> participant_;
  wire::Publication<msg::Request> requests_;
  wire::Publication<msg::CommandFrame> frames_;
  wire::Subscription<msg::Reply> replies_;
  wire::Subscription<msg::CommandReply> command_replies_;
  wire::Subscription<msg::BenchDescription> descriptions_;
};

void print(const std::string& figure, double value) {
  std::cout << R"({"figure":")" << figure << R"(","value":)" << value << "}\n";
}

void print_times(const std::string& figure, std::vector<double>& microseconds) {
  std::sort(microseconds.begin(), microseconds.end());
  print(figure + "_p50", microseconds[microseconds.size() / 2]);
  print(figure + "_p99", microseconds[microseconds.size() * 99 / 100]);
}

double microseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

void measure_steps(Client& client) {
  std::vector<double> times;
  const auto begin = Clock::now();
  for (int count = 0; count < kSteps; ++count) {
    msg::Request step;
    step.kind = msg::RequestKind::step;
    step.ticks = 1;
    const auto sent = Clock::now();
    static_cast<void>(client.exchange(step));
    times.push_back(microseconds_since(sent));
  }
  print("steps_per_second", kSteps * 1e6 / microseconds_since(begin));
  print_times("step_us", times);
}

void measure_commands(Client& client) {
  std::mutex mutex;
  std::condition_variable changed;
  std::uint64_t shown = 0;
  const wire::Subscription<msg::StatusFrame> status(
      client.participant(), [&](const msg::StatusFrame& frame, const wire::Source&) {
        if (frame.axes.front().last_sequence != shown) {
          const std::lock_guard lock(mutex);
          shown = frame.axes.front().last_sequence;
          changed.notify_one();
        }
      });
  msg::Request acquire;
  acquire.kind = msg::RequestKind::acquire;
  acquire.axes.push_back(1);
  const std::uint32_t epoch = client.exchange(acquire).epoch;
  std::vector<double> times;
  for (std::uint64_t sequence = 1; sequence <= kCommands; ++sequence) {
    // At any point between two ticks.
    std::this_thread::sleep_for(std::chrono::microseconds(1'000 + sequence * 37 % 1'000));
    const auto sent = Clock::now();
    client.send(epoch, sequence);
    std::unique_lock lock(mutex);
    if (changed.wait_for(lock, 1s, [&] {
          return shown >= sequence;
        })) {
      times.push_back(microseconds_since(sent));
    }
  }
  print("commands_shown", static_cast<double>(times.size()));
  print_times("command_to_status_us", times);
}

void measure_publication(Client& client, const test::ServiceProcess& service) {
  std::atomic<std::uint64_t> axes{0};
  const auto measure = [&] {
    const double before = service.processor_seconds();
    std::this_thread::sleep_for(kPublishing);
    return service.processor_seconds() - before;
  };
  const double alone = measure();
  const wire::Subscription<msg::StatusFrame> status(
      client.participant(), [&](const msg::StatusFrame& frame, const wire::Source&) {
        axes += frame.axes.size();
      });
  static_cast<void>(
      const_cast<wire::Subscription<msg::StatusFrame>&>(status).wait_for_matched(1, 5s));
  axes = 0;
  const double watched = measure();
  print("axes_received", static_cast<double>(axes.load()));
  print("service_seconds_alone", alone);
  print("service_seconds_watched", watched);
  print("publication_ns_per_axis", (watched - alone) * 1e9 / static_cast<double>(axes.load()));
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3) {
    std::cerr << "usage: vdrive_wire_benchmark VDRIVED step|command|publish [argument...]\n";
    return 2;
  }
  const std::string what = arguments[2];
  const test::ServiceProcess service(arguments[1], {arguments + 3, arguments + count});
  Client client;
  if (!client.find()) {
    std::cerr << "no bench 1\n";
    return 1;
  }
  if (what == "step") {
    measure_steps(client);
  } else if (what == "command") {
    measure_commands(client);
  } else {
    measure_publication(client, service);
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
// The cost of the status of one axis in the service that sends it and the client that receives it,
// next to that of the DDS library alone with the same bytes, frames and QoS.
//
//   vdrive_publication_benchmark AXES [ROUNDS]
//
// One thread does all the work for the status of a tick: copy of the image, encoding, ring, writer,
// socket. A second process receives it. Rounds of vdrive and of the library alone alternate, each
// of 100 ticks a millisecond apart. Prints the medians of processor time as JSON lines:
//   {"figure":"publication_ns_per_axis","axes":1024,"value":...}
#include "bare_node.hpp"
#include "base/counters.hpp"
#include "configuration/configuration.hpp"
#include "publish/status_depth.hpp"
#include "publish/status_publisher.hpp"
#include "seam/queues.hpp"
#include "seam/wire_link.hpp"
#include "seam/wire_region.hpp"
#include "streams/status_feed.hpp"
#include "support/test_domain.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/status_frame.hpp"
#include "wire/wire_program.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <functional>
#include <iostream>
#include <numeric>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace vdrive;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int kTicks = 100;
constexpr int kRounds = 21;
constexpr std::uint32_t kBench = 1;
constexpr std::uint64_t kIncarnation = 1;

double seconds_of(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// The counters of the receiving process, in shared memory.
struct Received {
  std::atomic<std::uint64_t> bare_axes{0};
  std::atomic<std::uint64_t> axes{0};
};

std::vector<std::uint16_t> numbers(std::size_t axes) {
  std::vector<std::uint16_t> all(axes);
  std::iota(all.begin(), all.end(), std::uint16_t{1});
  return all;
}

[[noreturn]] void receive(std::uint32_t domain, std::size_t axes, Received& received) {
  bare::Listener listener([&received](const bare::Bytes& sample) {
    received.bare_axes += sample.size() / bare::kAxis;
  });
  bare::Node node(domain);
  node.read("bare_status", false, listener);
  client::StatusFeed feed({kBench, kIncarnation}, numbers(axes), 1);
  client::Observation observation;
  const auto participant =
      wire::make_participant({.domain = domain, .role = wire::Role::client}, "receiver");
  const auto status =
      participant->make_reader(wire::Topic<msg::StatusFrame>::kId,
                               {.take =
                                    [&feed](std::span<const std::byte> sample) {
                                      feed.on_frame(*wire::StatusFrameView::of(sample));
                                    },
                                .deliver =
                                    [&feed, &observation, &received](const wire::Source&) {
                                      while (feed.take(observation))
                                        received.axes += observation.axes.size();
                                    }});
  while (true) std::this_thread::sleep_for(1s);
}

/// The part of a service from the image of a tick to the socket, in a single thread.
class Publisher {
 public:
  Publisher(std::uint32_t domain, std::size_t axes)
      : settings_{.network = {.domain = domain, .role = wire::Role::service},
                  .bench = kBench,
                  .log_level = "error",
                  .status_room = service::status_depth(configuration(axes)).room},
        region_(settings_),
        program_(region_, settings_),
        link_(region_),
        publisher_(link_, configuration(axes), {.bench = kBench, .incarnation = kIncarnation},
                   counters_),
        status_(axes),
        owners_(axes) {
    link_.send_through(program_);
    link_.control().running_generation = 1;
    link_.control().state = service::WireState::running;
    image_.status.resize(axes);
    image_.owners.resize(axes);
  }

  [[nodiscard]] bool wait_for_reader() const {
    return bare::wait_until(
        [this] {
          return link_.matched(wire::Topic<msg::StatusFrame>::kId) > 0;
        },
        10s);
  }

  void publish() {
    image_.tick += 1;
    std::ranges::copy(status_, image_.status.begin());
    std::ranges::copy(owners_, image_.owners.begin());
    publisher_.publish(image_);
  }

 private:
  static service::Configuration configuration(std::size_t axes) {
    service::Configuration with;
    with.bench = kBench;
    with.axes = service::default_axes(static_cast<std::uint16_t>(axes));
    return with;
  }

  service::WireSettings settings_;
  service::WireRegion region_;
  service::WireProgram program_;
  service::WireLink link_;
  service::Counters counters_;
  service::StatusPublisher publisher_;
  std::vector<AxisStatus> status_;
  std::vector<wire::Ownership> owners_;
  service::StatusImage image_;
};

/// Publishes the same bytes with the library alone.
class BarePublisher {
 public:
  BarePublisher(std::uint32_t domain, std::size_t axes)
      : node_(domain), writer_(node_.writer("bare_status", false)) {
    for (std::size_t first = 0; first < axes; first += bare::kAxesPerFrame) {
      frames_.emplace_back(
          bare::kFrameHead + std::min(bare::kAxesPerFrame, axes - first) * bare::kAxis,
          std::uint8_t{0x55});
    }
  }

  [[nodiscard]] bool wait_for_reader() const { return bare::wait_for_reader(writer_); }

  void publish() {
    for (bare::Bytes& frame : frames_) writer_.write(&frame);
  }

 private:
  bare::Node node_;
  bare::dds::DataWriter& writer_;
  std::vector<bare::Bytes> frames_;
};

/// The processor time of a round, per axis and tick [ns].
struct Cost {
  double sender = 0.0;
  double receiver = 0.0;  ///< per axis that arrived
  double arrived = 0.0;   ///< share
};

Cost measure(const std::function<void()>& publish, const std::atomic<std::uint64_t>& axes_received,
             clockid_t receiver, std::size_t axes) {
  const std::uint64_t received_before = axes_received;
  const double receiver_before = seconds_of(receiver);
  const double sender_before = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  auto next = Clock::now();
  for (int tick = 0; tick < kTicks; ++tick) {
    publish();
    next = std::max(next + 1ms, Clock::now());
    std::this_thread::sleep_until(next);
  }
  const double sender = seconds_of(CLOCK_THREAD_CPUTIME_ID) - sender_before;
  const std::uint64_t sent = axes * kTicks;
  // Anything that does not arrive is lost and reduces the share.
  static_cast<void>(bare::wait_until(
      [&] {
        return axes_received - received_before >= sent;
      },
      1s));
  const double receiver_seconds = seconds_of(receiver) - receiver_before;
  const auto arrived = static_cast<double>(axes_received - received_before);
  return {.sender = sender * 1e9 / static_cast<double>(sent),
          .receiver = receiver_seconds * 1e9 / std::max(arrived, 1.0),
          .arrived = arrived / static_cast<double>(sent)};
}

double median(std::vector<Cost> costs, double Cost::*member) {
  std::ranges::sort(costs, {}, member);
  return costs[costs.size() / 2].*member;
}

void print(const std::string& what, const std::vector<Cost>& own, const std::vector<Cost>& bare,
           double Cost::*member, std::size_t axes) {
  bare::print_figure(what + "_ns_per_axis", median(own, member), axes);
  bare::print_figure("bare_" + what + "_ns_per_axis", median(bare, member), axes);
  bare::print_figure(what + "_to_bare", median(own, member) / median(bare, member), axes);
}

int run(std::size_t axes, int rounds) {
  const std::uint32_t domain = test::test_domain();
  Received& received = bare::shared_with_partners<Received>();
  const bare::Partner partner([=, &received] {
    receive(domain, axes, received);
  });
  clockid_t receiver{};
  clock_getcpuclockid(partner.process(), &receiver);
  Publisher own(domain, axes);
  BarePublisher alone(domain, axes);
  if (!own.wait_for_reader() || !alone.wait_for_reader()) {
    std::cerr << "no reader\n";
    return 1;
  }
  std::vector<Cost> costs;
  std::vector<Cost> bare_costs;
  for (int round = -1; round < rounds; ++round) {
    const Cost bare_cost = measure(
        [&] {
          alone.publish();
        },
        received.bare_axes, receiver, axes);
    const Cost cost = measure(
        [&] {
          own.publish();
        },
        received.axes, receiver, axes);
    if (round < 0) continue;  // the first round touches all memory
    costs.push_back(cost);
    bare_costs.push_back(bare_cost);
  }
  print("publication", costs, bare_costs, &Cost::sender, axes);
  print("reception", costs, bare_costs, &Cost::receiver, axes);
  bare::print_figure("publication_arrived", median(costs, &Cost::arrived), axes);
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  try {
    if (count == 2 || count == 3) {
      return run(std::stoul(arguments[1]), count == 3 ? std::stoi(arguments[2]) : kRounds);
    }
  } catch (const std::logic_error&) {  // not a number
  }
  std::cerr << "usage: vdrive_publication_benchmark AXES [ROUNDS]\n";
  return 2;
}

// SPDX-License-Identifier: Apache-2.0
// The programs that the network tests run on their hosts. They print one JSON object per line on
// standard output; `time` is in seconds of the monotonic clock.
//
//   network_client OPTIONS cycle AXIS...    moves each axis back and forth; reacquires lost axes
//   network_client OPTIONS group AXIS...    moves the axes together, back and forth, every other
//                                           one in the opposite direction; reacquires lost axes
//   network_client OPTIONS observe AXIS...  prints every change of state, owner, error and motion
//   network_client OPTIONS hold AXIS        keeps the axis enabled; a number on standard input is a
//                                           set-point, sent immediately in any state
//
//   OPTIONS: --domain NUMBER, --interface ADDRESS, --peer HOST, --discovery-server HOST:PORT
#include "service/probe.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/client/session.hpp"

#include <nlohmann/json.hpp>

#include <poll.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Arguments {
  client::SessionOptions network;
  std::string role;
  std::vector<std::string> axes;
};

double now() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

void print(Json line) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  line["time"] = now();
  std::cout << line.dump() << std::endl;
}

Arguments parse(const std::vector<std::string>& words) {
  Arguments arguments;
  const std::map<std::string, std::vector<std::string>*, std::less<>> options{
      {"--interface", &arguments.network.interfaces},
      {"--peer", &arguments.network.peers},
      {"--discovery-server", &arguments.network.discovery_servers}};
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--domain") {
      arguments.network.domain = static_cast<std::uint32_t>(std::stoul(words.at(++i)));
    } else if (const auto option = options.find(words[i]); option != options.end()) {
      option->second->push_back(words.at(++i));
    } else if (arguments.role.empty()) {
      arguments.role = words[i];
    } else {
      arguments.axes.push_back(words[i]);
    }
  }
  return arguments;
}

// ---- cycle -------------------------------------------------------------------------------------

/// 0.1 s each of acceleration, constant velocity and deceleration: nearly always in motion.
constexpr std::int32_t kFar = 4'096;
constexpr client::MoveOptions kMotion{.velocity = 20'480,
                                      .acceleration = 204'800,
                                      .deceleration = 204'800,
                                      .queue = false,
                                      .call = {}};

bool print_outcome(const std::string& axis, const char* call, const client::Outcome& outcome) {
  print({{"axis", axis},
         {"call", call},
         {"outcome", to_string(outcome.kind())},
         {"code", outcome.code()},
         {"message", outcome.message()}});
  return static_cast<bool>(outcome);
}

/// Enables the axis and moves it back and forth until a call fails.
void move_until_it_fails(client::Session& session, const std::string& name) {
  auto axis = session.axis(name);
  if (!axis) {
    print_outcome(name, "find", axis.outcome());
    return;
  }
  if (!print_outcome(name, "acquire", axis->acquire()) ||
      !print_outcome(name, "reset", axis->reset_fault()) ||
      !print_outcome(name, "enable", axis->enable())) {
    return;
  }
  std::int32_t target = kFar;
  while (print_outcome(name, "move", axis->move_to(target, kMotion))) target = kFar - target;
}

/// Counts the samples of an axis in the stream, and checks that none is repeated or out of order.
void count_samples(client::Session& session, const std::string& name, const std::stop_token& stop) {
  std::uint64_t samples = 0;
  std::uint64_t missed = 0;
  std::uint64_t skipped = 0;  // a stall of the host makes the tick number jump
  std::uint64_t last = 0;
  std::uint64_t first = 0;
  auto printed = Clock::now();
  while (!stop.stop_requested()) {
    const auto axis = session.axis(name);
    if (!axis) continue;
    auto follower = session.follow({axis->id()}, client::Pace::observe);
    if (!follower) continue;
    for (auto seen = follower->next(500ms); seen; seen = follower->next(500ms)) {
      if (last != 0 && seen->tick <= last) {
        print({{"axis", name}, {"invented", seen->tick}, {"after", last}});
      }
      if (first == 0) first = seen->tick;
      ++samples;
      missed += seen->missed;
      skipped += seen->skipped;
      last = seen->tick;
      if (Clock::now() - printed >= 100ms || stop.stop_requested()) {
        printed = Clock::now();
        print({{"axis", name},
               {"samples", samples},
               {"missed", missed},
               {"skipped", skipped},
               {"first", first},
               {"last", last}});
      }
      if (stop.stop_requested()) return;
    }
    // A new follower does not know the earlier samples, so the count starts again.
    print({{"axis", name}, {"stream", "silent"}});
    samples = missed = skipped = first = last = 0;
  }
}

void wait_for_termination() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  int received = 0;
  sigwait(&signals, &received);
}

int cycle(const Arguments& arguments) {
  client::Session session(arguments.network);
  std::vector<std::jthread> threads;
  for (const std::string& axis : arguments.axes) {
    threads.emplace_back([&session, axis](const std::stop_token& stop) {
      while (!stop.stop_requested()) move_until_it_fails(session, axis);
    });
    threads.emplace_back([&session, axis](const std::stop_token& stop) {
      count_samples(session, axis, stop);
    });
  }
  wait_for_termination();
  for (auto& thread : threads) thread.request_stop();
  session.interrupt();
  return 0;
}

// ---- group -------------------------------------------------------------------------------------

constexpr const char* kGroup = "group";

/// Enables the axes and moves them together until a call fails.
void move_together_until_it_fails(client::Session& session, const std::vector<std::string>& axes) {
  auto group = client::AxisGroup::create(session, axes);
  if (!group) {
    print_outcome(kGroup, "find", group.outcome());
    return;
  }
  if (!print_outcome(kGroup, "reset", group->reset_all()) ||
      !print_outcome(kGroup, "enable", group->enable_all())) {
    return;
  }
  Eigen::VectorXd targets(static_cast<Eigen::Index>(axes.size()));
  for (Eigen::Index i = 0; i < targets.size(); ++i) targets[i] = i % 2 == 0 ? kFar : -kFar;
  const Eigen::VectorXd home = Eigen::VectorXd::Zero(targets.size());
  bool is_out = false;
  while (print_outcome(kGroup, "move", group->move_together(is_out ? home : targets)))
    is_out = !is_out;
}

int group(const Arguments& arguments) {
  client::Session session(arguments.network);
  std::jthread thread([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) move_together_until_it_fails(session, arguments.axes);
  });
  wait_for_termination();
  thread.request_stop();
  session.interrupt();
  return 0;
}

// ---- observe -----------------------------------------------------------------------------------

Json seen_of(const client::AxisSnapshot& axis) {
  return {{"axis", client::to_string(axis.id)}, {"state", to_string(axis.state())},
          {"error", axis.status.error_code},    {"owner", axis.owner_session},
          {"epoch", axis.owner_epoch},          {"moving", axis.status.velocity_demand_value != 0}};
}

/// Prints each change of an axis. A follower permanently loses a bench that restarts.
void observe_axis(client::Session& session, client::AxisId id, const std::stop_token& stop) {
  Json last;
  while (!stop.stop_requested()) {
    auto follower = session.follow({id}, client::Pace::observe);
    if (!follower) continue;
    auto seen = follower->next(1000ms);
    for (; seen; seen = follower->next(1000ms)) {
      const auto& axis = seen->axes.front();
      Json now_seen = seen_of(axis);
      if (now_seen == last) continue;
      last = now_seen;
      now_seen["tick"] = seen->tick;
      now_seen["position"] = axis.status.load_position_actual_value;
      print(std::move(now_seen));
    }
    print({{"outcome", to_string(seen.outcome().kind())}});
  }
}

int observe(const Arguments& arguments) {
  client::Session session(arguments.network);
  std::vector<client::AxisId> axes;
  for (const std::string& name : arguments.axes) {
    const auto axis = session.axis(name);
    if (!axis) {
      print({{"outcome", axis.outcome().message()}});
      return 1;
    }
    axes.push_back(axis->id());
  }
  std::vector<std::jthread> threads;
  for (const client::AxisId id : axes) {
    threads.emplace_back([&session, id](const std::stop_token& stop) {
      observe_axis(session, id, stop);
    });
  }
  wait_for_termination();
  for (auto& thread : threads) thread.request_stop();
  session.interrupt();
  return 0;
}

// ---- hold --------------------------------------------------------------------------------------

/// Keeps an axis enabled by frames that do not depend on its state.
class Holder {
 public:
  Holder(const wire::NetworkSettings& network, client::AxisId id)
      : id_(id), probe_(network, id.bench) {
    probe_.client = static_cast<std::uint64_t>(getpid());
    probe_.session = static_cast<std::uint64_t>(getpid());
  }

  bool take() {
    if (!probe_.find_bench()) return false;
    const auto acquired = probe_.acquire({id_.axis});
    if (!acquired || acquired->reason != msg::Reason::none) return false;
    // Resets a fault, if any, then enables the axis.
    constexpr std::array<std::uint16_t, 5> kWords{0x00, 0x80, 0x06, 0x07, 0x0F};
    for (const std::uint16_t word : kWords) {
      auto frame = probe_.make_frame();
      add(frame, word, std::nullopt);
      if (!probe_.send(frame)) return false;
    }
    print({{"held", client::to_string(id_)}, {"session", probe_.session}, {"epoch", probe_.epoch}});
    return true;
  }

  void keep_alive() {
    auto frame = probe_.make_frame();
    frame.flags = 0;
    probe_.send(frame);
  }

  /// Sends the set-point and prints the reply.
  void point(std::int32_t target) {
    auto frame = probe_.make_frame();
    add(frame, 0x3F, target);
    const bool sent = probe_.send(frame);
    const std::uint64_t sequence = frame.sequence_number;
    print({{"sent", sequence}, {"taken", sent}});
    waiting_.emplace_back([this, sequence] {
      const auto reply = probe_.reply_to(sequence);
      Json line{{"reply", sequence}, {"arrived", reply.has_value()}};
      if (reply && !reply->refusals.empty()) line["reason"] = reply->refusals[0].reason;
      print(std::move(line));
    });
  }

 private:
  void add(msg::CommandFrame& frame, std::uint16_t word, std::optional<std::int32_t> target) const {
    auto& command = frame.axes.emplace_back();
    command.axis = id_.axis;
    command.ds402_controlword = word;
    command.members = msg::HAS_DS402_CONTROLWORD;
    if (target) {
      command.position_user_target_value = *target;
      command.members = msg::HAS_DS402_CONTROLWORD | msg::HAS_POSITION_USER_TARGET_VALUE;
    }
  }

  client::AxisId id_;
  Probe probe_;
  std::vector<std::jthread> waiting_;
};

int hold(const Arguments& arguments) {
  const auto id = client::parse_axis_id(arguments.axes.at(0));
  if (!id) return 2;
  Holder holder({.domain = arguments.network.domain.value_or(client::default_domain()),
                 .interfaces = arguments.network.interfaces,
                 .peers = arguments.network.peers,
                 .discovery_servers = arguments.network.discovery_servers},
                *id);
  if (!holder.take()) return 1;
  while (true) {
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    constexpr int kKeepAlivePeriod = 25;  // [ms]
    if (poll(&input, 1, kKeepAlivePeriod) <= 0) {
      holder.keep_alive();
      continue;
    }
    std::array<char, 64> text{};
    if (read(STDIN_FILENO, text.data(), text.size() - 1) <= 0) return 0;
    holder.point(std::stoi(text.data()));
  }
}

int run(const Arguments& arguments) {
  if (arguments.role == "cycle") return cycle(arguments);
  if (arguments.role == "group") return group(arguments);
  if (arguments.role == "observe") return observe(arguments);
  if (arguments.role == "hold") return hold(arguments);
  std::cerr << "network_client: no such role: " << arguments.role << '\n';
  return 2;
}

}  // namespace
}  // namespace vdrive::test

int main(int count, char** words) {
  // Blocked before the first thread starts, so that all threads leave the signal to sigwait.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  const auto arguments = vdrive::test::parse({words + 1, words + count});
  if (arguments.role != "hold") {
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  }
  return vdrive::test::run(arguments);
}

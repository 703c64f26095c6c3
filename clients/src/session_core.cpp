// SPDX-License-Identifier: Apache-2.0
// Set-up, what arrives, and who is there.
#include "session_core.hpp"

#include "service_watch.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <random>
#include <stdexcept>
#include <utility>

namespace vdrive::client {
namespace {

using Clock = Directory::Clock;
using std::chrono::milliseconds;

// After this without a further bench, all benches that are there have been found.
constexpr milliseconds kSettle{250};

// Between two looks at who is there.
constexpr milliseconds kWatchPeriod{5};

constexpr milliseconds kShortestSilence{50};

SessionOptions checked(SessionOptions options) {
  if (options.silence >= kShortestSilence) return options;
  throw std::runtime_error("the time without samples after which a service is lost, " +
                           std::to_string(options.silence.count()) + " ms, is below 50 ms");
}

std::uint64_t random_session() {
  std::random_device device;
  std::uint64_t number = 0;
  while (number == 0) number = (std::uint64_t{device()} << 32U) | device();
  return number;
}

std::string list_of(std::span<const PresentBench> benches) {
  if (benches.empty()) return "no bench was found";
  std::string text = "found";
  for (const PresentBench& bench : benches) {
    text += text == "found" ? " " : ", ";
    text += "bench " + std::to_string(bench.info.number) + " " + in_quotes(bench.info.name) +
            " with " + std::to_string(bench.info.axes.size()) + " axes";
  }
  return text;
}

Target target_of(const PresentBench& bench) {
  return {.key = bench.key(),
          .clock_mode = bench.info.clock_mode,
          .period = bench.info.period,
          .status_every_ticks = bench.info.status_every_ticks,
          .rate = bench.info.rate,
          .is_paused = bench.info.clock_mode == ClockMode::realtime && bench.info.rate == 0.0};
}

}  // namespace

std::string name_of(const Target& target) {
  return "bench " + std::to_string(target.key.number);
}

std::string name_of(const Target& target, std::uint16_t axis) {
  return "axis " + to_string(AxisId{target.key.number, axis});
}

std::string paused_text(const Target& target) {
  return name_of(target) + " is paused: rate 0";
}

std::string restarted_text(const Target& target) {
  return name_of(target) + " restarted: another run of its service has begun";
}

namespace {

/// @return nothing when the permissions of this participant do not name the topic.
template <typename Message>
std::unique_ptr<wire::Publication<Message>> publication_if_permitted(
    wire::Participant& participant) {
  try {
    return std::make_unique<wire::Publication<Message>>(participant);
  } catch (const wire::NotPermitted&) {
    return nullptr;
  }
}

}  // namespace

Outcome not_permitted(const Target& target) {
  return Outcome::refused(kNotPermitted, name_of(target) + " received no request");
}

SessionCore::SessionCore(const SessionOptions& options)
    : options_(checked(options)),
      id_(random_session()),
      participant_({.domain = options.domain,
                    .interfaces = options.interfaces,
                    .peers = options.peers,
                    .discovery_servers = options.discovery_servers,
                    .shared_memory = false,
                    .security = options.security,
                    .role = wire::Role::client},
                   "vdrive client"),
      request_publication_(publication_if_permitted<msg::Request>(participant_)),
      command_publication_(publication_if_permitted<msg::CommandFrame>(participant_)),
      reply_subscription_(participant_,
                          [this](const msg::Reply& message, const wire::Source& source) {
                            on_reply(message, source);
                          }),
      command_reply_subscription_(
          participant_,
          [this](const msg::CommandReply& message, const wire::Source& source) {
            on_command_reply(message, source);
          }),
      state_subscription_(participant_,
                          [this](const msg::BenchState& message, const wire::Source& source) {
                            on_state(message, source);
                          }),
      description_subscription_(
          participant_, [this](const msg::BenchDescription& message, const wire::Source& source) {
            on_description(message, source);
          }) {}

SessionCore::~SessionCore() {
  if (keep_alive_thread_.joinable()) {
    keep_alive_thread_.request_stop();
    keep_alive_thread_.join();
  }
  watch_services(nullptr);
  (void)release();  // nobody is left to be told
}

/// A run of the service whose samples no longer arrive. Guarded by the caller's lock.
Outcome SessionCore::gone(const Target& target) {
  if (directory_.is_restarted(target.key, Clock::now())) {
    return Outcome::lost(restarted_text(target));
  }
  return Outcome::lost(name_of(target) + " stopped sending or ended");
}

void SessionCore::watch_services(std::function<void(const ServiceChange&)> observer) {
  watch_thread_ = {};  // ends the last watch
  if (!observer) return;
  subscribe_status();
  watch_thread_ = std::jthread([this, observe = std::move(observer)](const std::stop_token& stop) {
    ServiceWatch watch;
    std::condition_variable_any sleep;
    std::mutex sleep_mutex;
    std::unique_lock sleeping(sleep_mutex);
    while (!stop.stop_requested()) {
      std::vector<ServiceChange> changes;
      {
        const std::scoped_lock lock(mutex_);
        changes = watch.look(directory_, Clock::now());
      }
      for (const ServiceChange& change : changes) observe(change);
      sleep.wait_for(sleeping, stop, kWatchPeriod, [] {
        return false;
      });
    }
  });
}

// ---- what arrives ----------------------------------------------------------------------------

void SessionCore::on_description(const msg::BenchDescription& message, const wire::Source& source) {
  if (options_.bench && message.bench() != *options_.bench) return;
  const std::scoped_lock lock(mutex_);
  directory_.on_description(message, source, Clock::now());
  changed_.notify_all();
}

void SessionCore::on_state(const msg::BenchState& message, const wire::Source& source) {
  if (options_.bench && message.bench() != *options_.bench) return;
  const std::scoped_lock lock(mutex_);
  directory_.on_state(message, Clock::now());
  directory_.speaks({message.bench(), message.incarnation()}, source);
  changed_.notify_all();
}

void SessionCore::on_reply(const msg::Reply& message, const wire::Source& source) {
  if (message.client() != id_) return;
  const std::scoped_lock lock(mutex_);
  const BenchKey key{message.bench(), message.incarnation()};
  directory_.heard(key, message.tick(), Clock::now());
  directory_.speaks(key, source);
  const auto request = requests_.find(message.request_id());
  if (request == requests_.end()) return;
  request->second.reply = message;
  changed_.notify_all();
}

void SessionCore::on_command_reply(const msg::CommandReply& message, const wire::Source& source) {
  if (message.session() != id_) return;
  const std::scoped_lock lock(mutex_);
  const BenchKey key{message.bench(), message.incarnation()};
  directory_.speaks(key, source);
  const auto command = commands_.find({key, message.sequence_number()});
  if (command != commands_.end()) {
    command->second.reply = message;
    changed_.notify_all();
  }
  // A frame of the present epoch that is refused as a whole says that control is gone.
  const auto holding = holdings_.find(key.number);
  if (holding == holdings_.end() || holding->second.key != key) return;
  if (message.sequence_number() < holding->second.epoch_since) return;
  const bool gone = std::ranges::any_of(message.refusals(), [](const msg::Refusal& refusal) {
    return refusal.axis() == 0 && (refusal.reason() == msg::REASON_STALE_EPOCH ||
                                   refusal.reason() == msg::REASON_WRONG_INCARNATION);
  });
  if (gone) holding->second.axes.clear();
}

void SessionCore::on_status(const msg::StatusFrame& message, const wire::Source& source) {
  if (options_.bench && message.bench() != *options_.bench) return;
  const std::scoped_lock lock(mutex_);
  const BenchKey key{message.bench(), message.incarnation()};
  directory_.heard(key, message.tick(), Clock::now());
  directory_.speaks(key, source);
  for (const auto& weak : feeds_) {
    if (const auto feed = weak.lock()) feed->on_frame(message);
  }
  changed_.notify_all();
}

std::vector<PresentBench> SessionCore::find_benches() {
  Lock lock(mutex_);
  std::size_t count = 0;
  auto settled = Clock::time_point::max();
  (void)wait_to_find(lock, [&] {
    const auto now = Clock::now();
    const std::size_t present = directory_.present(now).size();
    if (present != count) settled = now + kSettle;
    count = present;
    return count != 0 && now >= settled;
  });
  return directory_.present(Clock::now());
}

Result<PresentBench> SessionCore::find_bench(std::optional<std::uint32_t> number) {
  if (!number && !options_.bench) {
    std::vector<PresentBench> benches = find_benches();
    if (benches.size() == 1) return std::move(benches.front());
    return Outcome::not_found((benches.empty() ? "" : "several benches, name one: ") +
                              list_of(benches) + " on domain " + std::to_string(options_.domain));
  }
  const std::uint32_t wanted = number.value_or(options_.bench.value_or(0));
  Lock lock(mutex_);
  std::optional<PresentBench> found;
  (void)wait_to_find(lock, [&] {
    found = directory_.find(wanted, Clock::now());
    return found.has_value();
  });
  if (found) return std::move(*found);
  return Outcome::not_found("no bench " + std::to_string(wanted) + " on domain " +
                            std::to_string(options_.domain) + ", " +
                            list_of(directory_.present(Clock::now())));
}

Result<AxisInfo> SessionCore::find_axis(std::string_view text) {
  if (const auto id = parse_axis_id(text)) {
    const auto bench = find_bench(id->bench);
    if (!bench)
      return Outcome::not_found("no axis " + to_string(*id) + ": " + bench.outcome().message());
    for (const AxisInfo& axis : bench->info.axes) {
      if (axis.id == *id) return axis;
    }
    return Outcome::not_found("no axis " + to_string(*id) + ", " + list_of({&*bench, 1}));
  }
  return find_name(text, find_benches());
}

Result<AxisInfo> SessionCore::find_name(std::string_view name,
                                        std::span<const PresentBench> benches) const {
  std::vector<AxisInfo> matches;
  for (const PresentBench& bench : benches) {
    std::ranges::copy_if(bench.info.axes, std::back_inserter(matches), [&](const AxisInfo& axis) {
      return axis.name == name;
    });
  }
  if (matches.size() == 1) return std::move(matches.front());
  if (matches.empty()) {
    return Outcome::not_found("no axis is named " + in_quotes(name) + " on domain " +
                              std::to_string(options_.domain) + ", " + list_of(benches));
  }
  return Outcome::not_found("several axes are named " + in_quotes(name) + ": " +
                            to_string(matches[0].id) + ", " + to_string(matches[1].id));
}

Result<Target> SessionCore::connect(std::uint32_t number) {
  const auto bench = find_bench(number);
  if (!bench) return bench.outcome();
  const Target target = target_of(*bench);
  if (!may_command()) return target;  // sees what is published
  if (Outcome matched = await_match(target); !matched) return matched;
  return target;
}

}  // namespace vdrive::client

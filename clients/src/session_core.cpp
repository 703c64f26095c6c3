// SPDX-License-Identifier: Apache-2.0
#include "session_core.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/wire/conversion.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <utility>

namespace vdrive::client {
namespace {

using Clock = Directory::Clock;
using std::chrono::milliseconds;

// After this silence a service counts as lost. Longer than kPresence, which only decides what is
// listed: a busy machine may hold a process up for some hundred milliseconds.
constexpr milliseconds kSilence{1000};

// A service that is heard answers within this, or it never will.
constexpr SessionCore::Patience kAnswer{milliseconds(10'000), false};

// After this without a further bench, all benches that are there have been found.
constexpr milliseconds kSettle{250};

// A running bench sends a sample of its status stream each tick; this allows for the match.
constexpr milliseconds kFirstSample{1000};

constexpr milliseconds kMatch{2000};
constexpr milliseconds kKeepAlivePeriod{25};
constexpr milliseconds kReleaseAnswer{500};

// One request steps at most this far, so that an interrupt or a lost service is noticed.
constexpr std::uint64_t kTicksPerRequest = 2000;

// Writing one of these takes a free axis for the session.
constexpr std::array<std::uint16_t, 5> kCommandObjects{0x6040, 0x6060, 0x607A, 0x60FF, 0x6071};

constexpr std::size_t kAxesPerRequest = msg::MAX_AXES_PER_FRAME;

std::uint64_t random_session() {
  std::random_device device;
  std::uint64_t number = 0;
  while (number == 0) number = (std::uint64_t{device()} << 32U) | device();
  return number;
}

std::string hex(std::uint64_t number) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text = "0x";
  for (unsigned shift = 64; shift != 0; shift -= 4) text += kDigits[(number >> (shift - 4)) & 0xFU];
  return text;
}

std::string name_of(const Target& target) {
  return "bench " + std::to_string(target.key.number);
}

std::string name_of(const Target& target, std::uint16_t axis) {
  return "axis " + to_string(AxisId{target.key.number, axis});
}

std::string list_of(std::span<const PresentBench> benches) {
  if (benches.empty()) return "no bench is there";
  std::string text = "found";
  for (const PresentBench& bench : benches) {
    text += text == "found" ? " " : ", ";
    text += "bench " + std::to_string(bench.info.number) + " '" + bench.info.name + "' with " +
            std::to_string(bench.info.axes.size()) + " axes";
  }
  return text;
}

/// Why a whole request was refused.
Outcome refusal_of(const Target& target, const msg::Reply& reply, std::string_view what) {
  std::string message(what);
  message += " refused";
  if (reply.owner_session() != 0) {
    message +=
        ", " +
        (reply.refused_axis() == 0 ? std::string("it") : name_of(target, reply.refused_axis())) +
        " is held by session " + hex(reply.owner_session());
  } else if (reply.refused_axis() != 0) {
    message += " because of " + name_of(target, reply.refused_axis());
  }
  return Outcome::refused(reply.reason(), std::move(message));
}

Outcome refusal_of(const Target& target, const msg::Refusal& refusal) {
  if (refusal.axis() == 0) {
    return Outcome::refused(refusal.reason(), name_of(target) + " refused the command frame");
  }
  std::string message = name_of(target, refusal.axis()) + " refused ";
  if (refusal.index() == 0) {
    message += "the command";
  } else {
    const auto row = find_object(ObjectAddress{refusal.index(), refusal.subindex()});
    message += row ? std::string(describe(*row).variable_name) : hex(refusal.index());
  }
  return Outcome::refused(refusal.reason(), std::move(message));
}

Target target_of(const PresentBench& bench) {
  return {.key = bench.key(),
          .clock_mode = bench.info.clock_mode,
          .period = bench.info.period,
          .status_every_ticks = bench.info.status_every_ticks,
          .source = bench.source};
}

}  // namespace

AxisSnapshot snapshot_of(const msg::AxisStatus& message) {
  return {.id = {message.bench(), message.axis()},
          .tick = message.tick(),
          .status = wire::from_message(message),
          .owner_session = message.owner_session(),
          .owner_epoch = message.owner_epoch(),
          .last_sequence = message.last_sequence()};
}

SessionCore::SessionCore(const SessionOptions& options)
    : options_(options),
      id_(random_session()),
      participant_({.domain = options.domain,
                    .interfaces = options.interfaces,
                    .peers = options.peers,
                    .shared_memory = false},
                   "vdrive client"),
      request_publication_(participant_),
      command_publication_(participant_),
      reply_subscription_(participant_,
                          [this](const msg::Reply& message, const wire::Source&) {
                            on_reply(message);
                          }),
      command_reply_subscription_(participant_,
                                  [this](const msg::CommandReply& message, const wire::Source&) {
                                    on_command_reply(message);
                                  }),
      state_subscription_(participant_,
                          [this](const msg::BenchState& message, const wire::Source&) {
                            on_state(message);
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
  (void)release();  // nobody is left to be told
}

// ---- what arrives ----------------------------------------------------------------------------

void SessionCore::on_description(const msg::BenchDescription& message, const wire::Source& source) {
  if (options_.bench && message.bench() != *options_.bench) return;
  const std::scoped_lock lock(mutex_);
  directory_.on_description(message, source);
  changed_.notify_all();
}

void SessionCore::on_state(const msg::BenchState& message) {
  if (options_.bench && message.bench() != *options_.bench) return;
  const std::scoped_lock lock(mutex_);
  directory_.on_state(message, Clock::now());
  changed_.notify_all();
}

void SessionCore::on_reply(const msg::Reply& message) {
  if (message.client() != id_) return;
  const std::scoped_lock lock(mutex_);
  directory_.heard({message.bench(), message.incarnation()}, message.tick(), Clock::now());
  const auto request = requests_.find(message.request_id());
  if (request == requests_.end()) return;
  request->second = message;
  changed_.notify_all();
}

void SessionCore::on_command_reply(const msg::CommandReply& message) {
  if (message.session() != id_) return;
  const std::scoped_lock lock(mutex_);
  const BenchKey key{message.bench(), message.incarnation()};
  const auto command = commands_.find({key, message.sequence_number()});
  if (command != commands_.end()) {
    command->second = message;
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

void SessionCore::on_status(const msg::StatusFrame& message) {
  if (options_.bench && message.bench() != *options_.bench) return;
  const std::scoped_lock lock(mutex_);
  directory_.heard({message.bench(), message.incarnation()}, message.tick(), Clock::now());
  for (const auto& weak : feeds_) {
    if (const auto feed = weak.lock()) feed->on_frame(message);
  }
  changed_.notify_all();
}

// ---- waiting ---------------------------------------------------------------------------------

template <typename Condition>
Outcome SessionCore::wait(Lock& lock, const Target& target, Patience patience,
                          const Condition& condition) {
  const auto deadline = Clock::now() + patience.timeout;
  while (!condition()) {
    const auto now = Clock::now();
    if (interrupted_ && patience.may_interrupt) return Outcome::failed("interrupted");
    if (!directory_.is_alive(target.key, kSilence, now)) {
      return Outcome::lost(name_of(target) + " fell silent or went away");
    }
    if (now >= deadline) return Outcome::timed_out(name_of(target) + " did not answer");
    changed_.wait_until(lock, std::min(deadline, now + milliseconds(50)));
  }
  return {};
}

template <typename Condition>
bool SessionCore::wait_to_find(Lock& lock, const Condition& condition) {
  const auto deadline = Clock::now() + options_.find_timeout;
  while (!condition()) {
    const auto now = Clock::now();
    if (interrupted_ || now >= deadline) return false;
    changed_.wait_until(lock, std::min(deadline, now + milliseconds(50)));
  }
  return true;
}

// ---- who is there ----------------------------------------------------------------------------

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
  std::vector<AxisInfo> matches;
  const std::vector<PresentBench> benches = find_benches();
  for (const PresentBench& bench : benches) {
    std::ranges::copy_if(bench.info.axes, std::back_inserter(matches), [&](const AxisInfo& axis) {
      return axis.name == text;
    });
  }
  if (matches.size() == 1) return std::move(matches.front());
  if (matches.empty()) {
    return Outcome::not_found("no axis is named '" + std::string(text) + "' on domain " +
                              std::to_string(options_.domain) + ", " + list_of(benches));
  }
  return Outcome::not_found("several axes are named '" + std::string(text) +
                            "': " + to_string(matches[0].id) + ", " + to_string(matches[1].id));
}

Result<Target> SessionCore::connect(std::uint32_t number) {
  const auto bench = find_bench(number);
  if (!bench) return bench.outcome();
  const Target target = target_of(*bench);
  if (!request_publication_.wait_for_match(target.source, kMatch) ||
      !reply_subscription_.wait_for_match(target.source, kMatch)) {
    return Outcome::lost(name_of(target) + " is there and cannot be asked: no match of requests");
  }
  return target;
}

Outcome SessionCore::await_command_match(const Target& target) {
  {
    const std::scoped_lock lock(mutex_);
    if (holding(target.key).is_matched_for_commands) return {};
  }
  if (!command_publication_.wait_for_match(target.source, kMatch) ||
      !command_reply_subscription_.wait_for_match(target.source, kMatch)) {
    return Outcome::lost(name_of(target) + " is there and hears no commands: no match");
  }
  const std::scoped_lock lock(mutex_);
  holding(target.key).is_matched_for_commands = true;
  return {};
}

// ---- requests --------------------------------------------------------------------------------

Result<msg::Reply> SessionCore::request(const Target& target, msg::Request request,
                                        std::string_view what) {
  Lock lock(mutex_);
  const std::uint64_t number = ++last_request_;
  requests_.emplace(number, std::nullopt);
  lock.unlock();
  request.client(id_);
  request.request_id(number);
  request.bench(target.key.number);
  request.incarnation(target.key.incarnation);
  request.session(id_);
  const bool sent = request_publication_.write(request);
  lock.lock();
  Outcome outcome = sent ? wait(lock, target, kAnswer,
                                [&] {
                                  return requests_.at(number).has_value();
                                })
                         : Outcome::lost(name_of(target) + " takes no more requests");
  std::optional<msg::Reply> reply = std::move(requests_.at(number));
  requests_.erase(number);
  if (!outcome) return outcome;
  if (reply->reason() != msg::REASON_NONE) return refusal_of(target, *reply, what);
  return std::move(*reply);
}

Result<msg::Reply> SessionCore::request_control(const Target& target, msg::Request request,
                                                std::string_view what) {
  const std::scoped_lock sending(send_mutex_);
  return this->request(target, std::move(request), what);
}

SessionCore::Holding& SessionCore::holding(const BenchKey& key) {
  Holding& holding = holdings_[key.number];
  if (holding.key != key) {
    holding = {};
    holding.key = key;
  }
  return holding;
}

void SessionCore::note_acquired(const Target& target, std::uint16_t axis, const msg::Reply& reply) {
  if (reply.epoch() == 0) return;
  {
    const std::scoped_lock lock(mutex_);
    Holding& held = holding(target.key);
    if (held.epoch != reply.epoch()) held.epoch_since = held.sequence + 1;
    held.epoch = reply.epoch();
    held.is_realtime = target.clock_mode == ClockMode::realtime;
    held.axes.insert(axis);
  }
  start_keep_alive();
}

Outcome SessionCore::acquire(const Target& target, std::uint16_t axis, bool shows_us) {
  if (Outcome matched = await_command_match(target); !matched) return matched;
  {
    const std::scoped_lock lock(mutex_);
    if (shows_us && holding(target.key).axes.contains(axis)) return {};
  }
  msg::Request request;
  request.kind(msg::REQUEST_ACQUIRE);
  request.axes().push_back(axis);
  const auto reply =
      request_control(target, std::move(request), "control of " + name_of(target, axis));
  if (!reply) return reply.outcome();
  note_acquired(target, axis, *reply);
  return {};
}

Result<msg::Reply> SessionCore::write(const Target& target, msg::Request request,
                                      std::string_view what) {
  const bool commands = std::ranges::any_of(request.objects(), [](const msg::ObjectAccess& access) {
    return std::ranges::find(kCommandObjects, access.index()) != kCommandObjects.end();
  });
  if (commands) {
    if (Outcome matched = await_command_match(target); !matched) return matched;
  }
  const std::uint16_t axis = request.objects().front().axis();
  auto reply = request_control(target, std::move(request), what);
  if (commands && reply && reply->objects().front().abort_code() == 0) {
    note_acquired(target, axis, *reply);
  }
  return reply;
}

Outcome SessionCore::release() {
  std::map<std::uint32_t, Holding> holdings;
  {
    const std::scoped_lock lock(mutex_);
    holdings = holdings_;
    for (auto& [number, holding] : holdings_) holding.axes.clear();
  }
  Outcome result;
  for (const auto& [number, holding] : holdings) {
    if (holding.axes.empty()) continue;
    // Also after an interrupt, and to a service that may be gone: so not by request().
    const std::scoped_lock sending(send_mutex_);
    Lock lock(mutex_);
    const std::uint64_t id = ++last_request_;
    requests_.emplace(id, std::nullopt);
    lock.unlock();
    msg::Request request;
    request.client(id_);
    request.request_id(id);
    request.bench(number);
    request.incarnation(holding.key.incarnation);
    request.session(id_);
    request.kind(msg::REQUEST_RELEASE);
    const bool sent = request_publication_.write(request);
    lock.lock();
    const bool answered = sent && changed_.wait_for(lock, kReleaseAnswer, [&] {
      return requests_.at(id).has_value();
    });
    requests_.erase(id);
    if (!answered) result = Outcome::lost("bench " + std::to_string(number) + " did not answer");
  }
  return result;
}

void SessionCore::interrupt() noexcept {
  const std::scoped_lock lock(mutex_);
  interrupted_ = true;
  changed_.notify_all();
}

bool SessionCore::is_interrupted() {
  const std::scoped_lock lock(mutex_);
  return interrupted_;
}

// ---- commands --------------------------------------------------------------------------------

msg::CommandFrame SessionCore::next_frame(Holding& held) const {
  msg::CommandFrame frame;
  frame.bench(held.key.number);
  frame.incarnation(held.key.incarnation);
  frame.session(id_);
  frame.epoch(held.epoch);
  frame.sequence_number(++held.sequence);
  return frame;
}

Outcome SessionCore::send(const Target& target, std::span<const msg::AxisCommand> commands,
                          std::vector<std::uint64_t>& sequences) {
  const std::scoped_lock sending(send_mutex_);
  for (const msg::AxisCommand& command : commands) {
    Lock lock(mutex_);
    msg::CommandFrame frame = next_frame(holding(target.key));
    const std::uint64_t sequence = frame.sequence_number();
    commands_.emplace(PendingCommand{target.key, sequence}, std::nullopt);
    lock.unlock();
    frame.flags(msg::FRAME_WANT_REPLY);
    frame.axes().push_back(command);
    sequences.push_back(sequence);
    if (!command_publication_.write(frame)) {
      return Outcome::lost(name_of(target) + " takes no more commands");
    }
  }
  return {};
}

Result<Applied> SessionCore::collect(const Target& target, std::span<const std::uint64_t> sequences,
                                     Outcome outcome) {
  Applied applied;
  Lock lock(mutex_);
  for (const std::uint64_t sequence : sequences) {
    const auto entry = commands_.find({target.key, sequence});
    if (outcome) {
      outcome = wait(lock, target, kAnswer, [&] {
        return entry->second.has_value();
      });
    }
    if (outcome && !entry->second->refusals().empty()) {
      outcome = refusal_of(target, entry->second->refusals().front());
    } else if (outcome) {
      applied.tick = std::max(applied.tick, entry->second->tick());
      applied.set_point_ignored =
          applied.set_point_ignored || !entry->second->ignored_set_points().empty();
    }
    commands_.erase(entry);
  }
  if (!outcome) return outcome;
  return applied;
}

Result<Applied> SessionCore::command(const Target& target,
                                     std::span<const msg::AxisCommand> commands) {
  std::vector<std::uint64_t> sequences;
  Outcome outcome = send(target, commands, sequences);
  if (outcome && target.steps()) outcome = step(target, 1, {}).outcome();
  return collect(target, sequences, std::move(outcome));
}

// ---- drive time ------------------------------------------------------------------------------

std::uint64_t SessionCore::last_sequence(const BenchKey& key) {
  const std::scoped_lock lock(mutex_);
  return holding(key).sequence;
}

Result<Observation> SessionCore::step(const Target& target, std::uint64_t ticks,
                                      std::span<const std::uint16_t> axes) {
  std::uint64_t left = ticks;
  std::size_t shown = 0;
  Observation observation;
  do {
    if (left != 0 && is_interrupted()) return Outcome::failed("interrupted");
    msg::Request request;
    request.kind(msg::REQUEST_STEP);
    request.ticks(std::min(left, kTicksPerRequest));
    request.last_sequence(last_sequence(target.key));
    left -= request.ticks();
    if (left == 0) {  // the axes are shown once time has passed
      const std::size_t count = std::min(axes.size() - shown, kAxesPerRequest);
      request.axes().assign(axes.begin() + static_cast<std::ptrdiff_t>(shown),
                            axes.begin() + static_cast<std::ptrdiff_t>(shown + count));
      shown += count;
    }
    const std::size_t wanted = request.axes().size();
    const auto reply = this->request(target, std::move(request), "step of " + name_of(target));
    if (!reply) return reply.outcome();
    if (reply->statuses().size() != wanted) {
      return Outcome::failed(name_of(target) + " did not show the axes asked for");
    }
    observation.tick = reply->tick();
    for (const msg::AxisStatus& status : reply->statuses()) {
      observation.axes.push_back(snapshot_of(status));
    }
  } while (left != 0 || shown < axes.size());
  return observation;
}

Result<Observation> SessionCore::observe(const Target& target,
                                         std::span<const std::uint16_t> axes) {
  if (target.steps()) return step(target, 0, axes);
  const auto feed = open_feed(target, {axes.begin(), axes.end()});
  auto sample = next(target, *feed, kFirstSample);
  if (sample.outcome().kind() == OutcomeKind::timed_out) {
    return Outcome::timed_out(name_of(target) + " sends no status stream");
  }
  return sample;
}

std::shared_ptr<StatusFeed> SessionCore::open_feed(const Target& target,
                                                   std::vector<std::uint16_t> axes) {
  const auto feed =
      std::make_shared<StatusFeed>(target.key, std::move(axes), target.status_every_ticks);
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(feeds_, [](const auto& weak) {
      return weak.expired();
    });
    feeds_.push_back(feed);
  }
  subscribe_status();
  return feed;
}

Result<std::uint64_t> SessionCore::present_tick(const Target& target) {
  if (target.steps()) {
    const auto shown = step(target, 0, {});
    if (!shown) return shown.outcome();
    return shown->tick;
  }
  subscribe_status();
  const std::scoped_lock lock(mutex_);
  return directory_.tick(target.key);
}

Result<std::uint64_t> SessionCore::wait_for_tick(const Target& target, std::uint64_t tick) {
  if (target.steps()) {
    const auto present = present_tick(target);
    if (!present || *present >= tick) return present;
    const auto reached = step(target, tick - *present, {});
    if (!reached) return reached.outcome();
    return reached->tick;
  }
  subscribe_status();
  Lock lock(mutex_);
  std::uint64_t reached = 0;
  const Outcome outcome = wait(lock, target, {std::chrono::hours(24 * 365), true}, [&] {
    reached = directory_.tick(target.key);
    return reached >= tick;
  });
  if (!outcome) return outcome;
  return reached;
}

void SessionCore::subscribe_status() {
  std::call_once(status_subscribed_, [this] {
    status_subscription_ = std::make_unique<wire::Subscription<msg::StatusFrame>>(
        participant_, [this](const msg::StatusFrame& message, const wire::Source&) {
          on_status(message);
        });
  });
}

Result<Observation> SessionCore::next(const Target& target, StatusFeed& feed,
                                      milliseconds patience) {
  Lock lock(mutex_);
  std::optional<Observation> sample;
  const Outcome outcome = wait(lock, target, {patience, true}, [&] {
    sample = feed.take();
    return sample.has_value();
  });
  if (!outcome) return outcome;
  return std::move(*sample);
}

// ---- keeping control -------------------------------------------------------------------------

void SessionCore::start_keep_alive() {
  if (options_.keep_alive != KeepAlive::own_thread) return;
  std::call_once(keep_alive_started_, [this] {
    keep_alive_thread_ = std::jthread([this](const std::stop_token& stop) {
      keep_alive(stop);
    });
  });
}

void SessionCore::keep_alive(const std::stop_token& stop) {
  std::condition_variable_any sleep;
  std::mutex sleep_mutex;
  std::unique_lock sleeping(sleep_mutex);
  while (!stop.stop_requested()) {
    std::vector<std::uint32_t> benches;
    {
      const std::scoped_lock lock(mutex_);
      for (const auto& [number, holding] : holdings_) {
        if (holding.is_realtime && !holding.axes.empty()) benches.push_back(number);
      }
    }
    for (const std::uint32_t bench : benches) send_keep_alive(bench);
    sleep.wait_for(sleeping, stop, kKeepAlivePeriod, [] {
      return false;
    });
  }
}

void SessionCore::send_keep_alive(std::uint32_t bench) {
  // Busy: a frame or a request is on its way, which says the same.
  const std::unique_lock sending(send_mutex_, std::try_to_lock);
  if (!sending) return;
  Lock lock(mutex_);
  const msg::CommandFrame frame = next_frame(holdings_.at(bench));
  lock.unlock();
  (void)command_publication_.write(frame);  // what is not taken now is said again in 25 ms
}

}  // namespace vdrive::client

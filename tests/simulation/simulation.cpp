// SPDX-License-Identifier: Apache-2.0
#include "simulation/simulation.hpp"

#include "simulation/disturber.hpp"
#include "simulation/master.hpp"
#include "support/programs/generator.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace vdrive::simulation {
namespace {

constexpr std::size_t kMasters = 2;
constexpr std::size_t kDisturber = 2;  // index on the network
constexpr std::size_t kStepper = 3;
constexpr std::int64_t kStepPatience = 60 * kMillisecond;

service::Configuration configuration_of(const Options& options,
                                        const std::vector<test::DrawnAxis>& axes, Random& random) {
  constexpr std::array kClocks{service::ClockMode::realtime, service::ClockMode::realtime,
                               service::ClockMode::lockstep, service::ClockMode::freerun};
  constexpr std::array<std::chrono::microseconds, 8> kPeriods{
      std::chrono::microseconds{1'000}, std::chrono::microseconds{1'000},
      std::chrono::microseconds{1'000}, std::chrono::microseconds{1'000},
      std::chrono::microseconds{1'000}, std::chrono::microseconds{1'000},
      std::chrono::microseconds{500},   std::chrono::microseconds{2'000}};
  service::Configuration configuration;
  configuration.bench = kBench;
  configuration.clock = options.clock.value_or(random.pick<service::ClockMode>(kClocks));
  configuration.period = options.play == Play::fight
                             ? kPeriods.front()
                             : random.pick<std::chrono::microseconds>(kPeriods);
  configuration.threads = static_cast<std::uint32_t>(options.threads);
  configuration.watchdog = std::chrono::milliseconds{100};
  configuration.watchdog_is_chosen = random.per_mille(500);
  configuration.axes = service::default_axes(options.axes);
  for (std::size_t place = 0; place < axes.size(); ++place) {
    AxisConfiguration& axis = configuration.axes[place].configuration;
    axis.model = axes[place].model;
    axis.parameters = axes[place].parameters;
  }
  return configuration;
}

NetworkHabits draw_habits(Random& random) {
  const bool is_good = random.per_mille(300);
  return {.drops = is_good ? 0 : random.below(60),
          .doubles = is_good ? 0 : random.below(60),
          .delays = is_good ? 0 : random.below(60),
          .longest_delay = random.between(5 * kMillisecond, 400 * kMillisecond),
          .keeps_order = random.per_mille(500)};
}

Temper draw_temper(Play play, Random& random) {
  if (play == Play::fight) {
    return {
        .longest_pause = 2 * kMillisecond, .greed = 60, .rudeness = 80, .lapses = 5, .haste = 500};
  }
  return {.longest_pause = random.between(4 * kMillisecond, 30 * kMillisecond),
          .greed = random.below(20),
          .rudeness = random.below(60),
          .lapses = random.below(8)};
}

/// The complete simulation: time, network, clients, and one run of the service after another.
class World {
 public:
  explicit World(const Options& options)
      : options_(options),
        random_(options.seed),
        happenings_(options.trace),
        axes_(test::draw_axes(options.axes, options.play == Play::everything, random_)),
        configuration_(configuration_of(options, axes_, random_)),
        post_(draw_habits(random_), random_.bits()),
        back_(draw_habits(random_), random_.bits()),
        frames_back_(draw_habits(random_), random_.bits()),
        storage_(random_.bits()),
        disturber_(kDisturber,
                   {.restarts = options.play == Play::everything,
                    .test_bench = options.play == Play::everything,
                    .host = options.play == Play::everything,
                    .disk = options.play == Play::everything},
                   random_.bits(), storage_.disk, happenings_) {
    for (std::size_t place = 0; place < kMasters; ++place) {
      masters_.emplace_back(place, draw_temper(options.play, random_), random_.bits(), stamps_,
                            happenings_);
    }
    time_.on_wake([this](std::int64_t now) {
      live_until(now);
    });
    start_service();
  }

  Report run() {
    const double period = std::chrono::duration<double>(configuration_.period).count();
    auto ticks = static_cast<std::uint64_t>(std::ceil(options_.seconds / period));
    if (options_.stop_at_tick != 0) {
      // Runs to the last cycle of that tick: time may be paused there, and the service may restart.
      ticks = std::min(ticks, options_.stop_at_tick + 1);
    }
    while (happenings_.tick() < ticks && !happenings_.violation()) {
      if (disturber_.wants_restart() || bench_->was_killed()) start_service();
      bench_->cycle(mail_);
    }
    take_stock();
    report_.seed = options_.seed;
    report_.ticks = happenings_.tick();
    report_.seconds = static_cast<double>(report_.ticks) * period;
    report_.hash = happenings_.hash();
    report_.violation = happenings_.violation();
    return report_;
  }

 private:
  void start_service() {
    if (bench_) {
      take_stock();
      ++report_.restarts;
      report_.cut_saves += bench_->was_killed() ? 1 : 0;
      time_.now += random_.between(kMillisecond, 500 * kMillisecond);  // starting takes time
      bench_.reset();
      storage_.disk.end_process(random_.per_mille(500));
    }
    bench_.emplace(configuration_, axes_,
                   static_cast<std::uint64_t>(SimulatedTime::kWall + time_.now) + 1, time_,
                   options_.play == Play::everything ? &storage_ : nullptr, options_.sabotage,
                   happenings_);
    bench_->model().use(stamps_, revocations_);
    happenings_.record("the service starts", {bench_->incarnation()});
  }

  void take_stock() {
    report_.commands += bench_->model().commands();
    report_.refused_frames += bench_->model().refused_frames();
    report_.lost_masters += bench_->model().lost_masters();
    report_.jumps += bench_->counters().jumps.get();
    report_.stores += bench_->counters().saves.get();
    report_.failed_stores += bench_->counters().save_failures.get();
  }

  /// Runs all actors except the bench until `now`; afterwards everything that has arrived is in the
  /// inbox.
  void live_until(std::int64_t now) {
    const View view{bench_->incarnation(), bench_->image().tick, bench_->image().status,
                    bench_->image().owners};
    for (Master& master : masters_) {
      while (master.next_action() <= now) master.act(view, post_);
    }
    while (disturber_.next_action() <= now) disturber_.act(view, *bench_, time_, post_);
    if (configuration_.clock == service::ClockMode::lockstep && now >= next_step_) {
      request_steps(now);
    }
    while (post_.has_arrived(now)) bench_->receive(post_.take().second);
    while (back_.has_arrived(now)) hand_over(back_.take().second);
    while (frames_back_.has_arrived(now)) {
      const msg::CommandReply reply = frames_back_.take().second;
      for (Master& master : masters_) master.on(reply);
    }
  }

  void hand_over(const msg::Reply& reply) {
    for (Master& master : masters_) master.on(reply);
    disturber_.on(reply);
    if (reply.client == kStepperClient && reply.request_id == last_step_) next_step_ = 0;
  }

  /// One program steps the bench, sometimes for a master, whose frames the step waits for. It
  /// continues when it has an answer or has waited long enough.
  void request_steps(std::int64_t now) {
    msg::Request request;
    request.client = kStepperClient;
    request.request_id = ++last_step_;
    request.bench = kBench;
    request.kind = msg::RequestKind::step;
    request.ticks = random_.below(12);
    if (random_.per_mille(400)) {
      request.session = masters_[random_.below(kMasters)].session();
      request.last_sequence = random_.per_mille(200) ? random_.below(2'000) : 0;
    }
    next_step_ = now + kStepPatience;
    post_.send(kStepper, std::move(request), now);
  }

  static constexpr std::uint64_t kStepperClient = 0x57E9;

  const Options options_;
  Random random_;
  Happenings happenings_;
  std::vector<test::DrawnAxis> axes_;
  service::Configuration configuration_;
  SimulatedTime time_;
  Post post_;
  Network<msg::Reply> back_;
  Network<msg::CommandReply> frames_back_;
  Storage storage_;
  Stamps stamps_;
  ControlModel::Revocations revocations_;
  std::vector<Master> masters_;
  Disturber disturber_;
  std::int64_t next_step_ = 0;
  std::uint64_t last_step_ = 0;
  Report report_;
  std::optional<Bench> bench_;
  Mail mail_{[this](const msg::Reply& reply) {
               back_.send(kDisturber, reply, time_.now);
             },
             [this](const msg::CommandReply& reply) {
               frames_back_.send(kDisturber, reply, time_.now);
             }};
};

}  // namespace

void Report::add(const Report& other) {
  ticks += other.ticks;
  seconds += other.seconds;
  commands += other.commands;
  refused_frames += other.refused_frames;
  lost_masters += other.lost_masters;
  jumps += other.jumps;
  restarts += other.restarts;
  stores += other.stores;
  failed_stores += other.failed_stores;
  cut_saves += other.cut_saves;
}

Report simulate(const Options& options) {
  return World(options).run();
}

}  // namespace vdrive::simulation

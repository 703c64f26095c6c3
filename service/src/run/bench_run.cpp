// SPDX-License-Identifier: Apache-2.0
#include "run/bench_run.hpp"

#include "base/log.hpp"
#include "base/works_for.hpp"
#include "configuration/configuration_warnings.hpp"
#include "publish/status_depth.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

#include <algorithm>
#include <string>
#include <utility>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

/// The status thread wakes this long after a tick is due, and sleeps at least this long.
constexpr std::chrono::microseconds kAfterTick = 60us;
/// The longest sleep of the status thread: while time stands still no tick is due, but the last
/// status still has to be sent.
constexpr std::chrono::milliseconds kLongestNap = 5ms;
/// The longest sleep of the reporter: news of the wire and periodic reports do not ring its bell.
constexpr std::chrono::milliseconds kLongestReportNap = 5ms;
/// The same while an answer waits for its reader, whose appearance does not ring the bell either.
constexpr std::chrono::milliseconds kHeldReplyNap = 1ms;
/// The minimum time between two rounds of reports, and in freerun between two rounds of status. In
/// freerun each of 100,000 ticks a second may produce an answer; those of a round are sent
/// together.
constexpr std::chrono::microseconds kReportNap = 500us;
/// The time for the wire to send what is in its lanes, such as the last states and the end of the
/// bench.
constexpr std::chrono::milliseconds kTimeOfLastSamples = 200ms;
/// The same in lock-step, where no axis had to brake, so more of the 2 s for the shutdown is left.
/// A client on a busy machine may still be waiting for the refusal of its step.
constexpr std::chrono::milliseconds kTimeOfLastSamplesInLockstep = 1s;

/// @return an incarnation later than those of all earlier benches of this process, even if the wall
///         clock is coarse or was set back.
std::uint64_t new_incarnation(std::chrono::nanoseconds now) noexcept {
  static std::atomic<std::uint64_t> last{0};
  std::uint64_t before = last;
  std::uint64_t mine = 0;
  do {
    mine = std::max(static_cast<std::uint64_t>(now.count()), before + 1);
  } while (!last.compare_exchange_weak(before, mine));
  return mine;
}

void prepare_tick_thread(int priority) {
  prctl(PR_SET_TIMERSLACK, 1UL);  // by default the kernel may wake a thread 50 us late
  if (priority == 0) return;
  const sched_param parameters{.sched_priority = priority};
  if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) != 0) {
    log_warning(
        "realtime_priority={} not permitted (RLIMIT_RTPRIO); the tick thread runs with normal "
        "priority",
        priority);
  }
}

}  // namespace

BenchRun::StoredParameters::StoredParameters(std::unique_ptr<ParameterStore> store,
                                             Configuration& configuration) {
  if (!store) return;
  directory = store->directory();
  LoadedParameters loaded = store->load();
  news = apply(loaded, configuration);
  const bool is_of_an_axis = std::ranges::any_of(news, [](const auto& event) {
    return event.axis != 0;
  });
  if (is_of_an_axis) store->keep_damaged();
  saver.emplace(std::move(store), std::move(loaded.table));
}

BenchRun::BenchRun(Configuration configuration, JournalSink journal,
                   std::unique_ptr<ParameterStore> store, const MakeWire& make_wire,
                   LockstepThreads lockstep_threads)
    : configuration_(std::move(configuration)),
      lockstep_threads_(lockstep_threads),
      parameters_(std::move(store), configuration_),
      identity_{configuration_.bench, new_incarnation(timer_.wall_now())},
      name_("bench " + std::to_string(identity_.bench)),
      wire_(make_wire(configuration_, counters_)),
      notices_(wire_->region().ring(Lane::notices)),
      duplicates_(identity_),
      inbox_(configuration_.bench, wire_->region().ring(Lane::arrivals),
             wire_->region().ring(Lane::turned_away), counters_),
      outbox_(configuration_.axes.size(), status_depth(configuration_).images),
      engine_(configuration_, identity_, outbox_, counters_),
      pages_(configuration_, engine_.black_box()),
      replies_(wire_->link(), identity_, counters_,
               [this](OutgoingReply& outgoing) {
                 pages_.complete(outgoing);
               }),
      status_(wire_->link(), configuration_, identity_, counters_),
      reports_(wire_->link(), configuration_, identity_, engine_.bank(), counters_),
      doorbell_(wire_->link().control().arrivals_bell, Doorbell::Waiting::quick),
      reports_doorbell_(reports_bell_) {
  if (parameters_.directory) {
    window_files_.emplace(*parameters_.directory, configuration_);
    window_files_->load(engine_.black_box());
  }
  if (journal) journal_.emplace(configuration_, std::move(journal), counters_);
  for (const EventRecord& event : parameters_.news) engine_.report(event);
  if (parameters_.saver) engine_.store_with(*parameters_.saver);
}

BenchRun::~BenchRun() {
  stop();
}

void BenchRun::start() {
  const WorksFor bench(name_.c_str());
  wire_->start();
  timer_.wait_until(timer_.monotonic_now() + wire_->duplicate_detection_time());
  while (receive_notices()) {
  }
  if (duplicates_.conflict()) {
    throw BenchNumberTaken(
        "bench " + std::to_string(identity_.bench) + " is already served in domain " +
        std::to_string(configuration_.network.domain) + " by " + duplicates_.older_text() +
        ", which started earlier; stop that service, or choose another number with --bench");
  }
  if (journal_) engine_.record_to(*journal_);
  if (parameters_.saver) {
    parameters_.saver->start([this] {
      doorbell_.ring();
      if (works_in_callers()) static_cast<void>(work());
    });
  }
  reports_.announce(true);
  run();
  is_announced_ = true;
  log_info("bench={} name={} axes={} clock={} period_us={} domain={} {} incarnation={}",
           identity_.bench, configuration_.name, configuration_.axes.size(),
           to_string(configuration_.clock), configuration_.period.count(),
           configuration_.network.domain,
           configuration_.network.security.empty() ? "open" : "closed", identity_.incarnation);
  for (const std::string& warning : start_warnings(configuration_)) {
    log_warning("bench={} configuration=\"{}\"", identity_.bench, warning);
  }
}

void BenchRun::run() {
  is_running_ = true;
  switch (configuration_.clock) {
    case ClockMode::realtime:
      start_realtime();
      break;
    case ClockMode::lockstep:
      start_lockstep();
      break;
    case ClockMode::freerun:
      start_freerun();
      break;
  }
}

void BenchRun::stop() noexcept {
  if (!std::exchange(is_running_, false)) return;
  is_announced_ = false;
  const WorksFor bench(name_.c_str());
  stop_ = true;
  doorbell_.ring();
  reports_doorbell_.ring();
  for (auto& thread : threads_) thread.join();
  threads_.clear();
  const std::scoped_lock lock(working_);  // a caller that runs the bench returns at the next tick
  // If the bench is in the user's process, steps still waiting return `lost`, as all other calls
  // do.
  if (lockstep_ && !works_in_callers()) lockstep_->end();
  switch_off();
  finish_stores();
  if (window_files_) {
    BlackBox& box = engine_.black_box();
    box.end_window(engine_.bank());
    while (box.handed_over() != nullptr) window_files_->save(box);
  }
  journal_.reset();  // writes its end mark; the engine is not used any more
  replies_.deliver(inbox_, outbox_);
  reports_.publish(inbox_, outbox_);
  reports_.announce(false);
  wire_->stop(lockstep_ ? kTimeOfLastSamplesInLockstep : kTimeOfLastSamples);
  log_info("bench={} offline", identity_.bench);
}

/// Finishes the orders of the saver and answers their requests, even if these arrived during the
/// shutdown.
void BenchRun::finish_stores() noexcept {
  if (parameters_.saver) parameters_.saver->close();
  while (engine_.answer_stores()) replies_.deliver(inbox_, outbox_);
}

template <typename Function>
void BenchRun::start_thread(Function function) {
  threads_.emplace_back([this, function] {
    const WorksFor bench(name_.c_str());
    function();
  });
}

void BenchRun::start_realtime() {
  realtime_.emplace(configuration_, engine_, inbox_, counters_, timer_);
  start_ticking(configuration_.realtime_priority, [this] {
    const std::uint64_t tick = engine_.tick();
    realtime_->cycle();
    return engine_.tick() != tick || engine_.time_stands();
  });
}

void BenchRun::start_freerun() {
  freerun_.emplace(engine_, inbox_, outbox_, timer_);
  start_ticking(0, [this] {
    freerun_->cycle();
    return true;
  });
}

/// @param priority of the tick thread, 0 = none
/// @param cycle runs one cycle of the driver and returns whether it made progress
template <typename Cycle>
void BenchRun::start_ticking(int priority, Cycle cycle) {
  start_thread([this, priority, cycle] {
    prepare_tick_thread(priority);
    engine_.schedule_as_caller();
    while (!stop_) {
      shutdown_.advance();
      if (cycle()) tick_beats_.add();
      if (outbox_.has_news() || inbox_.has_turned_away()) reports_doorbell_.ring();
    }
  });
  start_thread([this] {
    publish_status();
  });
  start_thread([this] {
    report();
  });
}

void BenchRun::start_lockstep() {
  lockstep_.emplace(configuration_, engine_, inbox_, outbox_, status_, replies_, stop_, doorbell_);
  beats_ = {{"steps", &lockstep_->beats()}, {"reports", &report_beats_}};
  liveness_ = Liveness(counts_of(beats_));
  if (works_in_callers()) {
    lockstep_->begin();
    static_cast<void>(work());
    return;
  }
  start_thread([this] {
    lockstep_->run();
  });
  start_thread([this] {
    report();
  });
}

wire::LocalWork BenchRun::work() {
  // Limits how long a thread works for others. Whatever is left belongs to threads that wait for
  // it, and those call work() again.
  constexpr int kMostRounds = 8;
  if (!works_in_callers()) return wire::LocalWork::none;
  const WorksFor bench(name_.c_str());
  int rounds = 0;
  is_work_wanted_ = true;
  // A thread that finds the lock taken returns; the thread that holds it checks again after it has
  // released it.
  while (is_work_wanted_ && rounds < kMostRounds) {
    const std::unique_lock lock(working_, std::try_to_lock);
    if (!lock.owns_lock()) return rounds > 0 ? wire::LocalWork::done : wire::LocalWork::elsewhere;
    is_work_wanted_ = false;
    while (!stop_ && rounds < kMostRounds && lockstep_->round()) ++rounds;
    report_once();
  }
  return rounds > 0 ? wire::LocalWork::done : wire::LocalWork::none;
}

void BenchRun::publish_status() {
  while (!stop_) {
    publish_waiting_status();
    wait_for_status();
  }
}

void BenchRun::publish_waiting_status() {
  while (const StatusImage* const image = outbox_.status.front()) {
    status_.publish(*image);
    outbox_.status.pop();
    status_beats_.add();
  }
}

/// Called after the last thread has ended. Axes that still have power, because there was no time to
/// brake, lose it in one last tick, whose status is published on the network. Sessions in the
/// process of the bench do not get that status: their waits would report an axis without power
/// instead of the loss of the bench.
void BenchRun::switch_off() noexcept {
  publish_waiting_status();
  if (engine_.has_power()) {
    engine_.shut_down(Braking::none);
    engine_.step();
  }
  const bool has_receivers = lockstep_threads_ == LockstepThreads::own;
  if (has_receivers && status_.last_tick() != engine_.tick()) {
    engine_.queue_status();
    publish_waiting_status();
  }
}

void BenchRun::report_once() {
  supervise_wire();
  static_cast<void>(receive_notices());
  if (!lockstep_) replies_.deliver(inbox_, outbox_, 1);
  reports_.publish(inbox_, outbox_);
  if (window_files_) window_files_->save(engine_.black_box());
  report_beats_.add();
}

void BenchRun::report() {
  bool is_conflict_reported = false;
  while (!stop_) {
    const auto earliest = timer_.monotonic_now() + kReportNap;
    report_once();
    if (const auto older = duplicates_.conflict(); older && !is_conflict_reported) {
      is_conflict_reported = true;
      reports_.publish_event({{.kind = msg::EventKind::bench_conflict,
                               .tick = counters_.tick.get(),
                               .detail = Label{*older}}});
    }
    // In lock-step another thread sends the answers.
    const bool holds_reply = !lockstep_ && replies_.is_waiting();
    if (reports_doorbell_.wait_for(holds_reply ? kHeldReplyNap : kLongestReportNap)) {
      timer_.wait_until(earliest);
    }
  }
}

bool BenchRun::receive_notices() {
  constexpr int kMostAtOnce = 64;  // the calling thread has other work
  for (int count = 0; count < kMostAtOnce; ++count) {
    const auto record = notices_.front();
    if (!record) return false;
    const auto topic = wire::topic_numbered(record->head.topic);
    const std::size_t size = std::min<std::size_t>(record->head.full_size, record->bytes.size());
    const auto sample = record->bytes.first(size);
    if (topic == wire::Topic<msg::BenchState>::kId) {
      duplicates_.note(sample, record->bytes.subspan(size));
    }
    if (topic == wire::Topic<msg::SessionName>::kId) reports_.note_session(sample);
    notices_.pop();
  }
  return true;
}

void BenchRun::supervise_wire() {
  wire_->supervise();
  is_cut_off_ = wire_->is_cut_off();
  while (auto news = wire_->next_news()) {
    news->tick = counters_.tick.get();
    reports_.publish_event({*news});
  }
  const std::uint64_t dropped = wire_->datagrams_dropped();
  counters_.datagrams_dropped.add(dropped - std::exchange(dropped_by_wire_, dropped));
  const WireControl& control = wire_->link().control();
  const std::uint64_t lost =
      control.overflows.load() + control.undelivered.load() + control.not_sent.load();
  counters_.queue_overflows.add(lost - std::exchange(lost_in_wire_, lost));
}

/// Sleeps until shortly after the next tick, for 60 us to 5 ms. In real time without readers it
/// always sleeps for 5 ms: the queue has room for the images of that time, and they are only
/// discarded.
void BenchRun::wait_for_status() {
  const auto now = timer_.monotonic_now();
  if (realtime_ && !status_.has_readers()) {
    timer_.wait_until(now + kLongestNap);
    return;
  }
  const auto wanted =
      realtime_ ? realtime_->next_cycle() + kAfterTick : now + std::chrono::nanoseconds(kReportNap);
  timer_.wait_until(std::clamp(wanted, now + std::chrono::nanoseconds(kAfterTick),
                               now + std::chrono::nanoseconds(kLongestNap)));
}

}  // namespace vdrive::service

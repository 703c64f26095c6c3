// SPDX-License-Identifier: Apache-2.0
#include "program/service.hpp"

#include "base/log.hpp"
#include "clock/cycle_timer.hpp"
#include "clock/freerun_driver.hpp"
#include "clock/lockstep_driver.hpp"
#include "clock/realtime_driver.hpp"
#include "clock/shutdown.hpp"
#include "configuration/configuration_warnings.hpp"
#include "engine/bench_engine.hpp"
#include "journal/journal.hpp"
#include "program/bench_guard.hpp"
#include "program/liveness.hpp"
#include "program/metrics.hpp"
#include "program/metrics_endpoint.hpp"
#include "publish/reply_publisher.hpp"
#include "publish/report_publisher.hpp"
#include "publish/status_depth.hpp"
#include "publish/status_publisher.hpp"
#include "seam/doorbell.hpp"
#include "seam/wire_link.hpp"
#include "supervision/wire_host.hpp"
#include "supervision/wire_supervisor.hpp"
#include "wire/closed_check.hpp"
#include "wire/wire_program.hpp"

#include <spdlog/spdlog.h>

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>
#include <utility>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

/// A thread that follows the tick thread wakes this long after the tick is due, and then again at
/// this distance.
constexpr std::chrono::microseconds kAfterTick = 60us;
/// While time stands no tick is due, and answers and reports still leave.
constexpr std::chrono::milliseconds kLongestNap = 5ms;
constexpr std::chrono::microseconds kReportNap = 500us;
/// The wire sends what is in its lanes, such as the last states and the end of the bench.
constexpr std::chrono::milliseconds kTimeOfLastSamples = 200ms;
/// A wire in its own process then announces its end; after this it is killed.
constexpr std::chrono::milliseconds kTimeToAnnounceEnd = 100ms;

void prepare_tick_thread(int priority) {
  prctl(PR_SET_TIMERSLACK, 1UL);  // the default lets the kernel wake it 50 us late
  if (priority == 0) return;
  const sched_param parameters{.sched_priority = priority};
  if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) != 0) {
    log_warning("realtime_priority={} not permitted; the tick thread runs without it", priority);
  }
}

}  // namespace

/// Stored parameters: loaded before there are axes, saved by a thread of their own.
struct Parameters {
  Parameters(std::unique_ptr<ParameterStore> store, Configuration& configuration) {
    if (store) {
      LoadedParameters loaded = store->load();
      news = apply(loaded, configuration);
      const bool is_of_an_axis = std::ranges::any_of(news, [](const auto& event) {
        return event.axis != 0;
      });
      if (is_of_an_axis) store->keep_aside();
      saver.emplace(std::move(store), std::move(loaded.table));
    }
  }

  std::vector<EventRecord> news;  ///< to be reported once
  std::optional<ParameterSaver> saver;
};

WireSettings wire_settings(const Configuration& configuration) {
  return {.network = configuration.network,
          .bench = configuration.bench,
          .log_level = std::string(spdlog::level::to_string_view(spdlog::get_level()).data()),
          .status_room = status_depth(configuration).room};
}

/// The wire of a bench in either form, and the memory that it shares with the engine.
class Wire {
 public:
  /// @param host of a wire's process; nothing = the wire is threads of this one
  Wire(std::shared_ptr<WireHost> host, const Configuration& configuration, Counters& counters)
      : host_(std::move(host)),
        network_(configuration.network),
        own_region_(host_ ? nullptr : std::make_unique<WireRegion>(wire_settings(configuration))),
        link_(region()) {
    if (host_) {
      supervisor_.emplace(region(), host_->spawner, configuration.wire_memory_limit, counters);
    } else {
      program_ = std::make_unique<WireProgram>(region(), wire_settings(configuration));
      link_.send_through(*program_);
      counters.wire_starts.add();
    }
  }

  [[nodiscard]] const WireRegion& region() const noexcept {
    return host_ ? host_->region : *own_region_;
  }

  [[nodiscard]] WireLink& link() noexcept { return link_; }

  /// Returns when it runs. With security material it first proves that strangers do not find it.
  /// @throws wire::NetworkError
  void start(Counters& counters) {
    if (supervisor_) {
      supervisor_->start();
      return;
    }
    if (!network_.security.empty()) check_closed(program_->participant(), network_);
    link_.control().running_generation = 1;
    link_.control().state = WireState::running;
    counters.wire_is_up.set(1);
  }

  void supervise() {
    if (supervisor_) supervisor_->supervise();
  }

  std::optional<EventRecord> next_news() {
    return supervisor_ ? supervisor_->next_news() : std::nullopt;
  }

  [[nodiscard]] bool is_cut_off() const noexcept {
    return supervisor_ && supervisor_->is_cut_off();
  }

  [[nodiscard]] std::uint64_t guarded() const {
    return program_ ? program_->guarded() : link_.control().guarded.load();
  }

  /// Waits until the readers have what was reported, and announces the end.
  void stop(std::chrono::milliseconds patience) {
    if (supervisor_) {
      supervisor_->stop(patience + kTimeToAnnounceEnd);
    } else {
      static_cast<void>(program_->wait_for_readers(patience));
      link_.control().state = WireState::none;
    }
  }

 private:
  std::shared_ptr<WireHost> host_;
  wire::NetworkSettings network_;
  std::unique_ptr<WireRegion> own_region_;
  WireLink link_;
  std::optional<WireSupervisor> supervisor_;
  std::unique_ptr<WireProgram> program_;
};

/// Members in the order of construction; everything the threads use outlives them.
class Service::Threads {
 public:
  Threads(Configuration configuration, JournalSink journal, std::unique_ptr<ParameterStore> store,
          std::shared_ptr<WireHost> host)
      : configuration_(std::move(configuration)),
        parameters_(std::move(store), configuration_),
        identity_{configuration_.bench, static_cast<std::uint64_t>(timer_.wall_now().count())},
        wire_(std::move(host), configuration_, counters_),
        guard_(wire_.region().ring(Lane::notices), identity_),
        inbox_(configuration_.bench, wire_.region().ring(Lane::arrivals),
               wire_.region().ring(Lane::turned_away), counters_),
        outbox_(configuration_.axes.size(), status_depth(configuration_).images),
        engine_(configuration_, identity_, outbox_, counters_),
        replies_(wire_.link(), identity_, counters_),
        status_(wire_.link(), configuration_, identity_, counters_),
        reports_(wire_.link(), configuration_, identity_, engine_.bank(), counters_),
        doorbell_(wire_.link().control().arrivals_bell, Doorbell::Waiting::quick) {
    serve_metrics();
    if (journal) journal_.emplace(configuration_, std::move(journal), counters_);
    for (const EventRecord& event : parameters_.news) engine_.report(event);
    if (parameters_.saver) engine_.store_with(*parameters_.saver);
  }

  ~Threads() { stop(); }

  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  void start() {
    wire_.start(counters_);
    timer_.wait_until(timer_.monotonic_now() + BenchGuard::kReceiving);
    guard_.receive();
    if (const auto older = guard_.conflict()) {
      throw BenchNumberTaken("bench " + std::to_string(identity_.bench) +
                             " is already served in domain " +
                             std::to_string(configuration_.network.domain) + " (incarnation " +
                             std::to_string(*older) + ")");
    }
    if (journal_) engine_.record_to(*journal_);
    if (parameters_.saver) {
      parameters_.saver->start([this] {
        doorbell_.ring();
      });
    }
    reports_.announce(true);
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
    log_info("bench={} name={} axes={} clock={} period_us={} domain={} {} incarnation={}",
             identity_.bench, configuration_.name, configuration_.axes.size(),
             to_string(configuration_.clock), configuration_.period.count(),
             configuration_.network.domain,
             configuration_.network.security.empty() ? "open" : "closed", identity_.incarnation);
    for (const std::string& warning : limit_warnings(configuration_)) {
      log_warning("bench={} configuration=\"{}\"", identity_.bench, warning);
    }
  }

  void begin_shutdown() noexcept { shutdown_.begin(); }

  /// In lock-step no client steps any more: no drive time is left to brake in.
  [[nodiscard]] bool is_shut_down() const noexcept { return lockstep_ || shutdown_.is_done(); }

  void stop() noexcept {
    if (running_.empty()) return;
    stop_ = true;
    doorbell_.ring();
    for (auto& thread : running_) thread.join();
    running_.clear();
    switch_off();
    finish_stores();
    journal_.reset();  // writes its end; the engine is not used any more
    replies_.deliver(inbox_, outbox_);
    reports_.publish(inbox_, outbox_);
    reports_.announce(false);
    wire_.stop(kTimeOfLastSamples);
    log_info("bench={} offline", identity_.bench);
  }

  [[nodiscard]] bool has_run() const noexcept { return liveness_.has_begun(); }

  [[nodiscard]] bool is_alive() noexcept { return liveness_.has_advanced(); }

  [[nodiscard]] std::optional<std::uint64_t> conflict() const noexcept { return guard_.conflict(); }

  [[nodiscard]] bool is_reachable() const noexcept { return counters_.wire_is_up.get() != 0; }

  [[nodiscard]] bool is_cut_off() const noexcept { return is_cut_off_; }

  [[nodiscard]] const BenchIdentity& identity() const noexcept { return identity_; }

  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }

 private:
  void serve_metrics() {
    if (!configuration_.metrics_port) return;
    metrics_ = std::make_unique<MetricsEndpoint>(
        *configuration_.metrics_port,
        std::make_unique<Metrics>(configuration_, identity_, counters_, [this] {
          return QueueDepths{.inbox = inbox_.size(), .outbox = outbox_.size()};
        }));
    log_info("bench={} metrics=http://127.0.0.1:{}/metrics", identity_.bench, metrics_->port());
  }

  /// Requests that arrived while the service ended are stored and answered too.
  void finish_stores() noexcept {
    if (parameters_.saver) parameters_.saver->close();
    while (engine_.answer_stores()) replies_.deliver(inbox_, outbox_);
  }

  void start_realtime() {
    realtime_.emplace(configuration_, engine_, inbox_, counters_, timer_);
    start_ticking(configuration_.realtime_priority, [this] {
      const std::uint64_t tick = engine_.tick();
      realtime_->cycle();
      return engine_.tick() != tick || engine_.time_stands();
    });
  }

  void start_freerun() {
    freerun_.emplace(engine_, inbox_, outbox_, timer_);
    start_ticking(0, [this] {
      freerun_->cycle();
      return true;
    });
  }

  /// @param priority of the tick thread, 0 = none
  /// @param cycle runs one cycle of the driver; @return whether it did what it should
  template <typename Cycle>
  void start_ticking(int priority, Cycle cycle) {
    running_.emplace_back([this, priority, cycle] {
      prepare_tick_thread(priority);
      engine_.schedule_as_caller();
      while (!stop_) {
        shutdown_.advance();
        if (cycle()) tick_beats_.add();
      }
    });
    running_.emplace_back([this] {
      publish_status();
    });
    running_.emplace_back([this] {
      report();
    });
  }

  void start_lockstep() {
    lockstep_.emplace(configuration_, engine_, inbox_, outbox_, status_, replies_, stop_,
                      doorbell_);
    liveness_ = Liveness({&lockstep_->beats(), &report_beats_});
    running_.emplace_back([this] {
      lockstep_->run();
    });
    running_.emplace_back([this] {
      report();
    });
  }

  void publish_status() {
    while (!stop_) {
      publish_waiting_status();
      nap(kAfterTick);
    }
  }

  void publish_waiting_status() {
    while (const StatusImage* const image = outbox_.status.front()) {
      status_.publish(*image);
      outbox_.status.pop();
      status_beats_.add();
    }
  }

  /// After the last thread has ended. Axes that still have power, because there was no time to
  /// brake, lose it in one last tick; every receiver sees it.
  void switch_off() noexcept {
    publish_waiting_status();
    if (engine_.has_power()) {
      engine_.shut_down(Braking::none);
      engine_.step();
    }
    if (status_.last_tick() != engine_.tick()) {
      engine_.post_status();
      publish_waiting_status();
    }
  }

  void report() {
    bool is_conflict_reported = false;
    while (!stop_) {
      supervise_wire();
      guard_.receive();
      if (!lockstep_) replies_.deliver(inbox_, outbox_);
      reports_.publish(inbox_, outbox_);
      report_beats_.add();
      if (const auto older = guard_.conflict(); older && !is_conflict_reported) {
        is_conflict_reported = true;
        reports_.publish_event({{.kind = msg::EVENT_BENCH_CONFLICT,
                                 .tick = counters_.tick.get(),
                                 .detail = Label{*older}}});
      }
      nap(kReportNap);
    }
  }

  void supervise_wire() {
    wire_.supervise();
    is_cut_off_ = wire_.is_cut_off();
    while (auto news = wire_.next_news()) {
      news->tick = counters_.tick.get();
      reports_.publish_event({*news});
    }
    counters_.guarded.set(wire_.guarded());
    const WireControl& control = wire_.link().control();
    const std::uint64_t lost =
        control.overflows.load() + control.undelivered.load() + control.not_sent.load();
    counters_.queue_overflows.add(lost - std::exchange(lost_in_wire_, lost));
  }

  /// Sleeps until shortly after the next tick, `shortest` to 5 ms.
  void nap(std::chrono::nanoseconds shortest) {
    const auto now = timer_.monotonic_now();
    auto wanted = now + std::chrono::nanoseconds(lockstep_ ? kLongestNap : kReportNap);
    if (realtime_) wanted = realtime_->next_cycle() + kAfterTick;
    timer_.wait_until(
        std::clamp(wanted, now + shortest, now + std::chrono::nanoseconds(kLongestNap)));
  }

  Configuration configuration_;
  Parameters parameters_;
  SystemCycleTimer timer_;
  BenchIdentity identity_;
  Counters counters_;
  Wire wire_;
  BenchGuard guard_;
  Inbox inbox_;
  Outbox outbox_;
  std::optional<Journal> journal_;
  BenchEngine engine_;
  ReplyPublisher replies_;
  StatusPublisher status_;
  ReportPublisher reports_;
  std::unique_ptr<MetricsEndpoint> metrics_;
  std::optional<RealtimeDriver> realtime_;
  std::optional<LockstepDriver> lockstep_;
  std::optional<FreerunDriver> freerun_;
  Doorbell doorbell_;
  std::uint64_t lost_in_wire_ = 0;
  Shutdown shutdown_{engine_, timer_};
  Counter tick_beats_;    ///< ticks; while paused, passes over the inbox
  Counter status_beats_;  ///< published images
  Counter report_beats_;  ///< rounds
  Liveness liveness_{{&tick_beats_, &status_beats_, &report_beats_}};
  std::atomic<bool> stop_{false};
  std::atomic<bool> is_cut_off_{false};
  std::vector<std::thread> running_;
};

Service::Service(Configuration configuration, JournalSink journal,
                 std::unique_ptr<ParameterStore> store, std::shared_ptr<WireHost> host) {
  check(configuration);
  threads_ = std::make_unique<Threads>(std::move(configuration), std::move(journal),
                                       std::move(store), std::move(host));
}

Service::~Service() = default;

void Service::start() {
  threads_->start();
}

bool Service::has_run() const noexcept {
  return threads_->has_run();
}

bool Service::is_alive() noexcept {
  return threads_->is_alive();
}

void Service::begin_shutdown() noexcept {
  threads_->begin_shutdown();
}

bool Service::is_shut_down() const noexcept {
  return threads_->is_shut_down();
}

void Service::stop() noexcept {
  threads_->stop();
}

std::optional<std::uint64_t> Service::conflict() const noexcept {
  return threads_->conflict();
}

bool Service::is_reachable() const noexcept {
  return threads_->is_reachable();
}

bool Service::is_cut_off() const noexcept {
  return threads_->is_cut_off();
}

const BenchIdentity& Service::identity() const noexcept {
  return threads_->identity();
}

const Counters& Service::counters() const noexcept {
  return threads_->counters();
}

}  // namespace vdrive::service

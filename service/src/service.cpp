// SPDX-License-Identifier: Apache-2.0
#include "vdrive/service/service.hpp"

#include "bench_guard.hpp"
#include "closed_check.hpp"
#include "doorbell.hpp"
#include "lockstep_driver.hpp"
#include "metrics.hpp"
#include "metrics_endpoint.hpp"
#include "reply_publisher.hpp"
#include "report_publisher.hpp"
#include "status_publisher.hpp"
#include "vdrive/service/cycle_timer.hpp"
#include "vdrive/service/freerun_driver.hpp"
#include "vdrive/service/journal.hpp"
#include "vdrive/service/liveness.hpp"
#include "vdrive/service/realtime_driver.hpp"
#include "vdrive/service/shutdown.hpp"
#include "vdrive/wire/subscription.hpp"

#include <spdlog/spdlog.h>

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

/// A thread that follows the tick thread wakes this long after the tick is due, and looks again at
/// this distance.
constexpr std::chrono::microseconds kAfterTick = 60us;
constexpr std::chrono::milliseconds kLongestNap = 5ms;
constexpr std::chrono::microseconds kReportNap = 500us;
constexpr std::chrono::milliseconds kFarewell = 200ms;

void prepare_tick_thread(int priority) {
  prctl(PR_SET_TIMERSLACK, 1UL);  // the default lets the kernel wake it 50 us late
  if (priority == 0) {
    return;
  }
  const sched_param parameters{.sched_priority = priority};
  if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) != 0) {
    spdlog::warn("realtime_priority={} not permitted; the tick thread runs without it", priority);
  }
}

}  // namespace

/// Stored parameters: loaded before there are axes, saved by a thread of their own.
struct Parameters {
  Parameters(std::unique_ptr<ParameterStore> store, Configuration& configuration) {
    if (store) {
      LoadedParameters loaded = store->load();
      news = apply(loaded, configuration);
      const bool is_of_an_axis = std::any_of(news.begin(), news.end(), [](const auto& event) {
        return event.axis != 0;
      });
      if (is_of_an_axis) {
        store->keep_aside();
      }
      saver.emplace(std::move(store), std::move(loaded.table));
    }
  }

  std::vector<EventRecord> news;  ///< to be told once
  std::optional<ParameterSaver> saver;
};

/// Members in the order of construction; everything the threads use outlives them.
class Service::Threads {
 public:
  Threads(Configuration configuration, JournalSink journal, std::unique_ptr<ParameterStore> store)
      : configuration_(std::move(configuration)),
        parameters_(std::move(store), configuration_),
        identity_{configuration_.bench, static_cast<std::uint64_t>(timer_.wall_now().count())},
        participant_(configuration_.network, "vdrived " + std::to_string(configuration_.bench)),
        listening_since_(timer_.monotonic_now()),
        guard_(participant_, identity_),
        inbox_(configuration_.bench, counters_),
        outbox_(configuration_.axes.size()),
        engine_(configuration_, identity_, outbox_, counters_),
        replies_(participant_, identity_, counters_),
        status_(participant_, configuration_, identity_, counters_),
        reports_(participant_, configuration_, identity_, engine_.bank(), counters_) {
    if (journal) {
      journal_.emplace(configuration_, std::move(journal), counters_);
    }
    for (const EventRecord& event : parameters_.news) {
      engine_.report(event);
    }
    if (parameters_.saver) {
      engine_.store_with(*parameters_.saver);
    }
  }

  ~Threads() { stop(); }

  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  void start() {
    if (!configuration_.network.security.empty()) {
      check_closed(participant_, configuration_.network);
    }
    timer_.wait_until(listening_since_ + BenchGuard::kListening);
    if (const auto older = guard_.conflict()) {
      throw BenchNumberTaken("bench " + std::to_string(identity_.bench) +
                             " is already served in domain " +
                             std::to_string(configuration_.network.domain) + " (incarnation " +
                             std::to_string(*older) + ")");
    }
    if (journal_) {
      engine_.record_to(*journal_);
    }
    serve_metrics();
    if (parameters_.saver) {
      parameters_.saver->start([this] {
        doorbell_.ring();
      });
    }
    subscribe();
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
    spdlog::info("bench={} name={} axes={} clock={} period_us={} domain={} {} incarnation={}",
                 identity_.bench, configuration_.name, configuration_.axes.size(),
                 to_string(configuration_.clock), configuration_.period.count(),
                 configuration_.network.domain,
                 configuration_.network.security.empty() ? "open" : "closed",
                 identity_.incarnation);
  }

  void begin_shutdown() noexcept { shutdown_.begin(); }

  /// In lock-step nobody steps any more: there is no time to brake in.
  [[nodiscard]] bool is_shut_down() const noexcept { return lockstep_ || shutdown_.is_done(); }

  void stop() noexcept {
    if (running_.empty()) {
      return;
    }
    frames_.reset();
    requests_.reset();
    stop_ = true;
    doorbell_.ring();
    for (auto& thread : running_) {
      thread.join();
    }
    running_.clear();
    switch_off();
    finish_stores();
    journal_.reset();  // writes its end; the engine is not used any more
    replies_.deliver(inbox_, outbox_);
    reports_.publish(inbox_, outbox_);
    reports_.announce(false);
    reports_.wait_for_readers(kFarewell);
    spdlog::info("bench={} offline", identity_.bench);
  }

  [[nodiscard]] bool has_run() const noexcept { return liveness_.has_begun(); }

  [[nodiscard]] bool is_alive() noexcept { return liveness_.has_advanced(); }

  [[nodiscard]] std::optional<std::uint64_t> conflict() const noexcept { return guard_.conflict(); }

  [[nodiscard]] const BenchIdentity& identity() const noexcept { return identity_; }

  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }

 private:
  void serve_metrics() {
    if (!configuration_.metrics_port) {
      return;
    }
    metrics_ = std::make_unique<MetricsEndpoint>(
        *configuration_.metrics_port,
        std::make_unique<Metrics>(configuration_, identity_, counters_, [this] {
          return QueueDepths{.inbox = inbox_.size(), .outbox = outbox_.size()};
        }));
    spdlog::info("bench={} metrics=http://127.0.0.1:{}/metrics", identity_.bench, metrics_->port());
  }

  /// What was asked for while the service ended is stored and answered too.
  void finish_stores() noexcept {
    if (parameters_.saver) {
      parameters_.saver->close();
    }
    while (engine_.answer_stores()) {
      replies_.deliver(inbox_, outbox_);
    }
  }

  void subscribe() {
    const auto take = [this](const auto& message, const wire::Source& source) {
      inbox_.receive(message, source);
      if (configuration_.clock == ClockMode::lockstep) {
        doorbell_.ring();
      }
    };
    frames_ = std::make_unique<wire::Subscription<msg::CommandFrame>>(participant_, take, take);
    requests_ = std::make_unique<wire::Subscription<msg::Request>>(participant_, take, take);
  }

  void start_realtime() {
    realtime_.emplace(configuration_, engine_, inbox_, counters_, timer_);
    running_.emplace_back([this] {
      prepare_tick_thread(configuration_.realtime_priority);
      while (!stop_) {
        shutdown_.advance();
        const std::uint64_t tick = engine_.tick();
        realtime_->cycle();
        if (engine_.tick() != tick || engine_.time_stands()) {
          tick_beats_.add();
        }
      }
    });
    running_.emplace_back([this] {
      publish_status();
    });
    running_.emplace_back([this] {
      report();
    });
  }

  void start_freerun() {
    freerun_.emplace(engine_, inbox_, outbox_, timer_);
    running_.emplace_back([this] {
      while (!stop_) {
        shutdown_.advance();
        freerun_->cycle();
        tick_beats_.add();
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
    lockstep_.emplace(configuration_, engine_, inbox_, outbox_, status_, replies_, counters_);
    liveness_ = Liveness({&lockstep_->beats(), &report_beats_});
    running_.emplace_back([this] {
      lockstep_->run(stop_, doorbell_);
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
  /// brake, lose it in one last tick; whoever listens sees it.
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
    reports_.publish_first_parameters();
    bool conflict_told = false;
    while (!stop_) {
      if (!lockstep_) {
        replies_.deliver(inbox_, outbox_);
      }
      reports_.publish(inbox_, outbox_);
      report_beats_.add();
      if (const auto older = guard_.conflict(); older && !conflict_told) {
        conflict_told = true;
        reports_.publish_event(
            {{.kind = msg::EVENT_BENCH_CONFLICT, .tick = counters_.tick.get(), .detail = *older}});
      }
      nap(kReportNap);
    }
  }

  /// Sleeps until shortly after the next tick, `shortest` to 5 ms.
  void nap(std::chrono::nanoseconds shortest) {
    const auto now = timer_.monotonic_now();
    auto wanted = now + std::chrono::nanoseconds(lockstep_ ? kLongestNap : kReportNap);
    if (realtime_) {
      wanted = realtime_->next_cycle() + kAfterTick;
    }
    timer_.wait_until(
        std::clamp(wanted, now + shortest, now + std::chrono::nanoseconds(kLongestNap)));
  }

  Configuration configuration_;
  Parameters parameters_;
  SystemCycleTimer timer_;
  BenchIdentity identity_;
  Counters counters_;
  wire::Participant participant_;
  std::chrono::nanoseconds listening_since_;
  BenchGuard guard_;
  Inbox inbox_;
  Outbox outbox_;
  std::optional<Journal> journal_;
  BenchEngine engine_;
  ReplyPublisher replies_;
  StatusPublisher status_;
  ReportPublisher reports_;
  std::unique_ptr<MetricsEndpoint> metrics_;
  std::unique_ptr<wire::Subscription<msg::CommandFrame>> frames_;
  std::unique_ptr<wire::Subscription<msg::Request>> requests_;
  std::optional<RealtimeDriver> realtime_;
  std::optional<LockstepDriver> lockstep_;
  std::optional<FreerunDriver> freerun_;
  Doorbell doorbell_;
  Shutdown shutdown_{engine_, timer_};
  Counter tick_beats_;    ///< ticks; paused, looks at the inbox
  Counter status_beats_;  ///< published images
  Counter report_beats_;  ///< rounds
  Liveness liveness_{{&tick_beats_, &status_beats_, &report_beats_}};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> running_;
};

Service::Service(Configuration configuration, JournalSink journal,
                 std::unique_ptr<ParameterStore> store) {
  check(configuration);
  threads_ =
      std::make_unique<Threads>(std::move(configuration), std::move(journal), std::move(store));
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

const BenchIdentity& Service::identity() const noexcept {
  return threads_->identity();
}

const Counters& Service::counters() const noexcept {
  return threads_->counters();
}

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#include "program/service.hpp"

#include "base/log.hpp"
#include "program/bench_probes.hpp"
#include "program/metrics.hpp"
#include "program/metrics_endpoint.hpp"
#include "run/bench_run.hpp"
#include "run/bench_wire.hpp"
#include "seam/wire_link.hpp"
#include "supervision/wire_host.hpp"
#include "supervision/wire_supervisor.hpp"
#include "wire/closed_check.hpp"
#include "wire/wire_program.hpp"

#include <chrono>
#include <string>
#include <utility>

namespace vdrive::service {
namespace {

/// The time for a wire in its own process to announce its end, before it is killed.
constexpr std::chrono::milliseconds kTimeToAnnounceEnd{100};

/// A wire in a separate process, which is restarted when it fails.
class ProcessWire final : public BenchWire {
 public:
  ProcessWire(std::shared_ptr<WireHost> host, const Configuration& configuration,
              Counters& counters)
      : host_(std::move(host)),
        link_(host_->region),
        supervisor_(host_->region, host_->spawner,
                    std::uint64_t{configuration.wire_memory_limit_mib} << 20U, counters) {}

  [[nodiscard]] const WireRegion& region() const noexcept override { return host_->region; }

  [[nodiscard]] WireLink& link() noexcept override { return link_; }

  void start() override { supervisor_.start(); }

  [[nodiscard]] std::chrono::milliseconds duplicate_detection_time() const noexcept override {
    return DuplicateNumberDetector::kReceiving;
  }

  void supervise() override { supervisor_.supervise(); }

  [[nodiscard]] std::optional<EventRecord> next_news() override { return supervisor_.next_news(); }

  [[nodiscard]] bool is_cut_off() const noexcept override { return supervisor_.is_cut_off(); }

  [[nodiscard]] std::uint64_t datagrams_dropped() const override {
    return link_.control().datagrams_dropped.load();
  }

  void stop(std::chrono::milliseconds patience) override {
    supervisor_.stop(patience + kTimeToAnnounceEnd);
  }

 private:
  std::shared_ptr<WireHost> host_;
  WireLink link_;
  WireSupervisor supervisor_;
};

/// A wire in threads of this process.
class ThreadWire final : public BenchWire {
 public:
  ThreadWire(const Configuration& configuration, Counters& counters)
      : network_(configuration.network),
        region_(wire_settings(configuration)),
        link_(region_),
        program_(region_, wire_settings(configuration)),
        counters_(counters) {
    link_.send_through(program_);
    counters.wire_starts.add();
  }

  [[nodiscard]] const WireRegion& region() const noexcept override { return region_; }

  [[nodiscard]] WireLink& link() noexcept override { return link_; }

  /// In the closed mode, first proves that strangers cannot discover the bench.
  void start() override {
    if (!network_.security.empty()) check_closed(program_.participant(), network_);
    link_.begin();
    counters_.wire_is_up.set(1);
  }

  [[nodiscard]] std::chrono::milliseconds duplicate_detection_time() const noexcept override {
    return DuplicateNumberDetector::kReceiving;
  }

  [[nodiscard]] std::uint64_t datagrams_dropped() const override {
    return program_.datagrams_dropped();
  }

  void stop(std::chrono::milliseconds patience) override {
    static_cast<void>(program_.wait_for_readers(patience));
    link_.end();
  }

 private:
  wire::NetworkSettings network_;
  WireRegion region_;
  WireLink link_;
  WireProgram program_;
  Counters& counters_;
};

std::unique_ptr<MetricsEndpoint> metrics_of(const BenchRun& run) {
  const Configuration& configuration = run.configuration();
  if (!configuration.metrics_port) return nullptr;
  auto metrics = std::make_unique<MetricsEndpoint>(
      configuration.metrics_address, *configuration.metrics_port,
      std::make_unique<Metrics>(configuration, run.identity(), run.counters()), probes_of(run));
  log_info("bench={} metrics=http://{}:{}/metrics", run.identity().bench,
           configuration.metrics_address, metrics->port());
  return metrics;
}

BenchRun::MakeWire wire_with(std::shared_ptr<WireHost> host) {
  return [host = std::move(host)](const Configuration& configuration,
                                  Counters& counters) -> std::unique_ptr<BenchWire> {
    if (host) return std::make_unique<ProcessWire>(host, configuration, counters);
    return std::make_unique<ThreadWire>(configuration, counters);
  };
}

}  // namespace

/// In the order of construction: the metrics read the running bench.
struct Service::Parts {
  Parts(Configuration configuration, JournalSink journal, std::unique_ptr<ParameterStore> store,
        std::shared_ptr<WireHost> host)
      : run(std::move(configuration), std::move(journal), std::move(store),
            wire_with(std::move(host))),
        metrics(metrics_of(run)) {}

  BenchRun run;
  std::unique_ptr<MetricsEndpoint> metrics;
};

Service::Service(Configuration configuration, JournalSink journal,
                 std::unique_ptr<ParameterStore> store, std::shared_ptr<WireHost> host) {
  check(configuration);
  parts_ = std::make_unique<Parts>(std::move(configuration), std::move(journal), std::move(store),
                                   std::move(host));
}

Service::~Service() = default;

void Service::start() {
  parts_->run.start();
}

bool Service::has_run() const noexcept {
  return parts_->run.has_run();
}

bool Service::is_alive() noexcept {
  return parts_->run.is_alive();
}

void Service::begin_shutdown() noexcept {
  parts_->run.begin_shutdown();
}

bool Service::is_shut_down() const noexcept {
  return parts_->run.is_shut_down();
}

void Service::stop() noexcept {
  parts_->run.stop();
}

std::optional<std::uint64_t> Service::conflict() const noexcept {
  return parts_->run.conflict();
}

std::string Service::older_text() const {
  return parts_->run.older_text();
}

bool Service::is_reachable() const noexcept {
  return parts_->run.is_reachable();
}

bool Service::is_cut_off() const noexcept {
  return parts_->run.is_cut_off();
}

const BenchIdentity& Service::identity() const noexcept {
  return parts_->run.identity();
}

const Counters& Service::counters() const noexcept {
  return parts_->run.counters();
}

}  // namespace vdrive::service

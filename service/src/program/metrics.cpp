// SPDX-License-Identifier: Apache-2.0
#include "program/metrics.hpp"

#include "vdrive/wire/conversion.hpp"

#include <limits>
#include <string>
#include <utility>

namespace vdrive::service {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

/// Puts families together; every metric carries the number of the bench.
class Families {
 public:
  explicit Families(std::string bench) : bench_(std::move(bench)) {}

  void counter(const char* name, const char* help, std::uint64_t value) {
    add(name, help, MetricType::Counter).counter.value = static_cast<double>(value);
  }

  void gauge(const char* name, const char* help, double value) {
    add(name, help, MetricType::Gauge).gauge.value = value;
  }

  /// The first metric of a new family.
  ClientMetric& add(const char* name, const char* help, MetricType type) {
    families_.push_back({.name = name, .help = help, .type = type, .metric = {}});
    return another();
  }

  /// Another metric of the last family.
  ClientMetric& another() {
    ClientMetric& metric = families_.back().metric.emplace_back();
    metric.label.push_back({"bench", bench_});
    return metric;
  }

  [[nodiscard]] std::vector<MetricFamily> take() { return std::move(families_); }

 private:
  std::string bench_;
  std::vector<MetricFamily> families_;
};

void add_ticks(Families& families, const Counters& counters) {
  families.gauge("vdrive_tick", "Number of the last tick",
                 static_cast<double>(counters.tick.get()));
  families.gauge("vdrive_rate", "Requested ratio of drive time to wall time, 0 = paused",
                 counters.rate.get());
  families.counter("vdrive_ticks_total", "Ticks that were run", counters.ticks_run.get());
  families.counter("vdrive_tick_overruns_total", "Ticks that took longer than their period",
                   counters.overruns.get());
  families.counter("vdrive_tick_jumps_total", "Jumps of the tick number", counters.jumps.get());
  families.counter("vdrive_ticks_skipped_total", "Ticks that the number jumped over: not run",
                   counters.tick.read().skipped);
  families.gauge("vdrive_wall_clock_offset_seconds",
                 "Wall clock minus drive time; 0 while drive time does not follow the wall clock",
                 counters.wall_offset.get());
  families.counter("vdrive_wall_clock_steps_total", "Changes of the wall clock that were detected",
                   counters.wall_steps.get());
}

void add_lateness(Families& families, const Counters& counters) {
  auto& histogram = families
                        .add("vdrive_tick_lateness_seconds",
                             "Time from the due time of a tick to its begin", MetricType::Histogram)
                        .histogram;
  std::uint64_t count = 0;
  double bound = 1e-6;
  for (const Counter& bin : counters.lateness) {
    count += bin.get();
    histogram.bucket.push_back({.cumulative_count = count, .upper_bound = bound});
    bound *= 2.0;
  }
  histogram.bucket.back().upper_bound = std::numeric_limits<double>::infinity();
  histogram.sample_count = count;
  histogram.sample_sum = static_cast<double>(counters.lateness_sum_ns.get()) * 1e-9;
}

void add_queues(Families& families, const Counters& counters, const QueueDepths& depths) {
  const auto depth = [](ClientMetric& metric, const char* queue, std::size_t value) {
    metric.label.push_back({"queue", queue});
    metric.gauge.value = static_cast<double>(value);
  };
  depth(families.add("vdrive_queue_depth", "Messages that wait in a queue", MetricType::Gauge),
        "inbox", depths.inbox);
  depth(families.another(), "outbox", depths.outbox);
  depth(families.another(), "pending_frames", counters.pending_frames.get());
  families.counter("vdrive_queue_overflows_total", "Messages lost because a queue was full",
                   counters.queue_overflows.get());
  const auto lost = [](ClientMetric& metric, const char* queue, const Counter& count) {
    metric.label.push_back({"queue", queue});
    metric.counter.value = static_cast<double>(count.get());
  };
  lost(families.add("vdrive_status_lost_total",
                    "Of these: status between tick and status thread, and between engine and wire",
                    MetricType::Counter),
       "images", counters.status_images_lost);
  lost(families.another(), "wire", counters.status_samples_lost);
}

void add_commands(Families& families, const Counters& counters) {
  families.counter("vdrive_frames_received_total", "Command frames that arrived",
                   counters.frames_received.get());
  families.counter("vdrive_frames_refused_total", "Command frames that were refused",
                   counters.frames_refused.get());
  families.counter("vdrive_commands_applied_total", "Commands to an axis that were carried out",
                   counters.commands_applied.get());
  families.counter("vdrive_commands_refused_total", "Commands to an axis that were refused",
                   counters.commands_refused.get());
  families.counter("vdrive_set_points_ignored_total", "Set-points that a drive ignored",
                   counters.set_points_ignored.get());
  families.counter("vdrive_requests_answered_total", "Requests that were answered",
                   counters.requests_answered.get());
  families.counter("vdrive_watchdog_trips_total",
                   "Masters that were lost because nothing was received from them in time",
                   counters.master_losses.get());
  families.gauge("vdrive_longest_silence_seconds",
                 "Longest time without a message from an owner of axes, in drive time",
                 static_cast<double>(counters.longest_silence_us.get()) / 1.0e6);
}

void add_wire(Families& families, const Counters& counters) {
  families.gauge("vdrive_wire_up", "1 while the service is on the network, 0 while it is not",
                 static_cast<double>(counters.wire_is_up.get()));
  families.counter("vdrive_wire_starts_total",
                   "Starts of the network process; 1 = it was never restarted",
                   counters.wire_starts.get());
  families.gauge("vdrive_wire_resident_bytes",
                 "Memory of the network process; 0 = DDS runs in threads of the service",
                 static_cast<double>(counters.wire_resident.get()));
  families.counter("vdrive_datagrams_dropped_total",
                   "Datagrams that were dropped because no conforming program sends them",
                   counters.datagrams_dropped.get());
  families.counter("vdrive_malformed_samples_total",
                   "Commands and requests that arrived and could not be decoded",
                   counters.malformed.get());
}

void add_refusals(Families& families, const Counters& counters) {
  bool is_first = true;
  for (const auto& [reason, count] : counters.refusals.counts()) {
    ClientMetric& metric =
        is_first ? families.add("vdrive_refusals_total",
                                "Refusals of frames, commands and requests by their reason",
                                MetricType::Counter)
                 : families.another();
    is_first = false;
    metric.label.push_back({"reason", wire::describe_reason(reason)});
    metric.counter.value = static_cast<double>(count);
  }
}

void add_published(Families& families, const Counters& counters) {
  families.counter("vdrive_status_frames_sent_total", "Samples of the topic status",
                   counters.status_frames_sent.get());
  families.counter("vdrive_axis_samples_sent_total", "Samples of the topic axis",
                   counters.axis_samples_sent.get());
  families.counter("vdrive_events_sent_total", "Samples of the topic event",
                   counters.events_sent.get());
  families.counter("vdrive_saves_total", "Axes whose stored parameters became durable",
                   counters.saves.get());
  families.counter("vdrive_save_failures_total", "Axes whose parameters could not be stored",
                   counters.save_failures.get());
  families.counter("vdrive_journal_ticks_total", "Ticks written to the journal",
                   counters.journal_ticks.get());
  families.counter("vdrive_journal_losses_total", "Ticks that are missing in the journal",
                   counters.journal_losses.get());
}

}  // namespace

Metrics::Metrics(const Configuration& configuration, const BenchIdentity& identity,
                 const Counters& counters, std::function<QueueDepths()> depths)
    : bench_(std::to_string(identity.bench)),
      name_(configuration.name),
      clock_(to_string(configuration.clock)),
      incarnation_(identity.incarnation),
      axes_(configuration.axes.size()),
      counters_(counters),
      depths_(std::move(depths)) {}

std::vector<MetricFamily> Metrics::Collect() const {
  Families families(bench_);
  ClientMetric& info =
      families.add("vdrive_info", "1; its labels describe the service", MetricType::Gauge);
  info.gauge.value = 1.0;
  info.label.push_back({"name", name_});
  info.label.push_back({"clock", clock_});
  info.label.push_back({"version", VDRIVE_VERSION});
  info.label.push_back({"incarnation", std::to_string(incarnation_)});
  families.gauge("vdrive_axes", "Axes of the bench", static_cast<double>(axes_));
  add_ticks(families, counters_);
  add_lateness(families, counters_);
  add_queues(families, counters_, depths_());
  add_wire(families, counters_);
  add_commands(families, counters_);
  add_refusals(families, counters_);
  add_published(families, counters_);
  return families.take();
}

}  // namespace vdrive::service

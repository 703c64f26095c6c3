// SPDX-License-Identifier: Apache-2.0
#include "metrics.hpp"

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::gateway {
namespace {

/// Builds the metrics, family by family.
class MetricFamilies {
 public:
  /// A counter that is the only one of its family.
  void counter(const char* name, const char* help, std::uint64_t value) {
    begin(name, help, prometheus::MetricType::Counter);
    add().counter.value = static_cast<double>(value);
  }

  /// A gauge that is the only one of its family.
  void gauge(const char* name, const char* help, double value) {
    begin(name, help, prometheus::MetricType::Gauge);
    add().gauge.value = value;
  }

  /// A gauge with one label.
  void labelled_gauge(const char* name, const char* help, const char* label, std::string text,
                      double value) {
    begin(name, help, prometheus::MetricType::Gauge);
    add(label, std::move(text)).gauge.value = value;
  }

  /// A gauge for each of `items`; no family if there are none.
  /// @param text returns the label text of an item
  /// @param value returns the value of an item
  template <typename Items, typename Text, typename Value>
  void gauges(const char* name, const char* help, const char* label, const Items& items,
              const Text& text, const Value& value) {
    if (items.empty()) return;
    begin(name, help, prometheus::MetricType::Gauge);
    for (const auto& item : items) add(label, text(item)).gauge.value = value(item);
  }

  /// Counters for the values of an enumeration, each with the label "reason".
  /// @param counts one per value, in order
  template <typename Kind, typename Counts>
  void counters(const char* name, const char* help, const Counts& counts) {
    begin(name, help, prometheus::MetricType::Counter);
    for (std::size_t kind = 0; kind < counts.size(); ++kind) {
      add("reason", std::string(to_string(static_cast<Kind>(kind)))).counter.value =
          static_cast<double>(counts[kind]);
    }
  }

  [[nodiscard]] const std::vector<prometheus::MetricFamily>& all() const noexcept {
    return families_;
  }

 private:
  void begin(const char* name, const char* help, prometheus::MetricType type) {
    families_.push_back({.name = name, .help = help, .type = type, .metric = {}});
  }

  prometheus::ClientMetric& add() { return families_.back().metric.emplace_back(); }

  prometheus::ClientMetric& add(const char* label, std::string text) {
    prometheus::ClientMetric& metric = add();
    metric.label.push_back({label, std::move(text)});
    return metric;
  }

  std::vector<prometheus::MetricFamily> families_;
};

void add_clients(MetricFamilies& families, const WebCounters& web) {
  families.gauge("vdrive_gateway_clients", "Open WebSockets", static_cast<double>(web.clients));
  families.counter("vdrive_gateway_connections_total", "WebSockets opened", web.connections);
  families.counters<Refusal>("vdrive_gateway_upgrades_refused_total",
                             "Refused requests to open a WebSocket", web.refused);
  families.counters<CutOff>("vdrive_gateway_clients_cut_off_total",
                            "WebSockets that the gateway closed because of their client",
                            web.cut_off);
  families.counter("vdrive_gateway_messages_sent_total", "Messages sent to clients",
                   web.messages_sent);
  families.counter("vdrive_gateway_bytes_sent_total", "Payload of the messages sent to clients",
                   web.bytes_sent);
  families.counter("vdrive_gateway_messages_dropped_total",
                   "Messages dropped for clients that read too slowly", web.dropped);
}

void add_channels(MetricFamilies& families, const GatewayCounts& counts) {
  families.gauge("vdrive_gateway_channels", "Topics", static_cast<double>(counts.channels));
  families.gauge("vdrive_gateway_channels_subscribed", "Topics with at least one subscriber",
                 static_cast<double>(counts.subscribed));
  families.gauge("vdrive_gateway_subscriptions", "Subscriptions of all clients",
                 static_cast<double>(counts.subscriptions));
  families.counter("vdrive_gateway_batches_lost_total",
                   "Publications of a bench dropped because the gateway was late",
                   counts.lost_batches);
  families.gauge("vdrive_gateway_controlled", "1 while a client holds control",
                 counts.is_controlled ? 1.0 : 0.0);
}

void add_benches(MetricFamilies& families, const std::vector<BenchPresence>& benches) {
  families.gauge("vdrive_gateway_benches", "Benches that have topics",
                 static_cast<double>(benches.size()));
  const auto number = [](const BenchPresence& bench) {
    return std::to_string(bench.number);
  };
  families.gauges("vdrive_gateway_bench_alive", "1 while samples of the bench arrive", "bench",
                  benches, number, [](const BenchPresence& bench) {
                    return bench.is_alive ? 1.0 : 0.0;
                  });
  families.gauges("vdrive_gateway_newest_sample_age_seconds",
                  "Age of the newest sample of the bench, in wall time", "bench", benches, number,
                  [](const BenchPresence& bench) {
                    return std::chrono::duration<double>(bench.sample_age).count();
                  });
}

}  // namespace

std::string metrics_text(const GatewayCounts& counts) {
  MetricFamilies families;
  families.labelled_gauge("vdrive_gateway_info",
                          "Always 1; the label is the version of the gateway", "version",
                          VDRIVE_VERSION, 1.0);
  add_clients(families, counts.web);
  add_channels(families, counts);
  add_benches(families, counts.benches);
  return prometheus::TextSerializer().Serialize(families.all());
}

}  // namespace vdrive::gateway

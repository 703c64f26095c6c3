// SPDX-License-Identifier: Apache-2.0
#include "metrics.hpp"

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <utility>

namespace vdrive::gateway {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

/// Puts families together.
class Families {
 public:
  void counter(const char* name, const char* help, std::uint64_t value) {
    begin(name, help, MetricType::Counter);
    add().counter.value = static_cast<double>(value);
  }

  void gauge(const char* name, const char* help, double value) {
    begin(name, help, MetricType::Gauge);
    add().gauge.value = value;
  }

  void begin(const char* name, const char* help, MetricType type) {
    families_.push_back({.name = name, .help = help, .type = type, .metric = {}});
  }

  /// A metric of the family begun last.
  ClientMetric& add() { return families_.back().metric.emplace_back(); }

  ClientMetric& add(const char* label, std::string value) {
    ClientMetric& metric = add();
    metric.label.push_back({label, std::move(value)});
    return metric;
  }

  /// Counters by the kinds of an enumeration.
  template <typename Kind, typename Counts>
  void counters(const char* name, const char* help, const Counts& counts) {
    begin(name, help, MetricType::Counter);
    for (std::size_t kind = 0; kind < counts.size(); ++kind) {
      add("reason", std::string(to_string(static_cast<Kind>(kind)))).counter.value =
          static_cast<double>(counts[kind]);
    }
  }

  [[nodiscard]] const std::vector<MetricFamily>& all() const noexcept { return families_; }

 private:
  std::vector<MetricFamily> families_;
};

void add_clients(Families& families, const WebCounters& web) {
  families.gauge("vdrive_gateway_clients", "WebSockets that are open",
                 static_cast<double>(web.clients));
  families.counter("vdrive_gateway_connections_total", "WebSockets that were opened",
                   web.connections);
  families.counters<Refusal>("vdrive_gateway_upgrades_refused_total",
                             "Requests to open a WebSocket that were refused", web.refused);
  families.counters<CutOff>("vdrive_gateway_clients_cut_off_total",
                            "WebSockets that the gateway closed because of their client",
                            web.cut_off);
  families.counter("vdrive_gateway_messages_sent_total", "Messages sent to clients",
                   web.messages_sent);
  families.counter("vdrive_gateway_bytes_sent_total", "Payload of the messages sent to clients",
                   web.bytes_sent);
  families.counter("vdrive_gateway_messages_dropped_total",
                   "Messages left out for clients that read too slowly", web.dropped);
}

void add_channels(Families& families, const GatewayCounts& counts) {
  families.gauge("vdrive_gateway_channels", "Topics", static_cast<double>(counts.channels));
  families.gauge("vdrive_gateway_channels_subscribed", "Topics that some client receives",
                 static_cast<double>(counts.subscribed));
  families.gauge("vdrive_gateway_subscriptions", "Subscriptions of all clients",
                 static_cast<double>(counts.subscriptions));
  families.counter("vdrive_gateway_batches_lost_total",
                   "Publications of a bench left out because the gateway was late",
                   counts.lost_batches);
  families.gauge("vdrive_gateway_controlled", "1 while a client holds control",
                 counts.is_controlled ? 1.0 : 0.0);
}

void add_benches(Families& families, const std::vector<BenchPresence>& benches) {
  families.gauge("vdrive_gateway_benches", "Benches that have topics",
                 static_cast<double>(benches.size()));
  if (benches.empty()) return;
  families.begin("vdrive_gateway_bench_alive", "1 while samples of the bench arrive",
                 MetricType::Gauge);
  for (const BenchPresence& bench : benches) {
    families.add("bench", std::to_string(bench.number)).gauge.value = bench.is_alive ? 1.0 : 0.0;
  }
  families.begin("vdrive_gateway_newest_sample_age_seconds",
                 "How old the newest sample of the bench is, in wall time", MetricType::Gauge);
  for (const BenchPresence& bench : benches) {
    families.add("bench", std::to_string(bench.number)).gauge.value =
        std::chrono::duration<double>(bench.sample_age).count();
  }
}

}  // namespace

std::string metrics_text(const GatewayCounts& counts) {
  Families families;
  families.begin("vdrive_gateway_info", "1; its label has the version of the gateway",
                 MetricType::Gauge);
  families.add("version", VDRIVE_VERSION).gauge.value = 1.0;
  add_clients(families, counts.web);
  add_channels(families, counts);
  add_benches(families, counts.benches);
  return prometheus::TextSerializer().Serialize(families.all());
}

}  // namespace vdrive::gateway

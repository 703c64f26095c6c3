// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <prometheus/metric_family.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::bridge {

/// Puts the metrics of a bridge together, family by family.
class MetricFamilies {
 public:
  /// A counter alone in its family.
  void counter(const char* name, const char* help, std::uint64_t value) {
    begin(name, help, prometheus::MetricType::Counter);
    add().counter.value = static_cast<double>(value);
  }

  /// A gauge alone in its family.
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

  /// A gauge for each of `items`; no family when there is none.
  /// @param text gives the text of the label of an item
  /// @param value gives the value of an item
  template <typename Items, typename Text, typename Value>
  void gauges(const char* name, const char* help, const char* label, const Items& items,
              const Text& text, const Value& value) {
    if (items.empty()) return;
    begin(name, help, prometheus::MetricType::Gauge);
    for (const auto& item : items) add(label, text(item)).gauge.value = value(item);
  }

  /// Counters by the kinds of an enumeration, each with the label "reason".
  /// @param counts one for each kind, in their order
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

}  // namespace vdrive::bridge

// SPDX-License-Identifier: Apache-2.0
#include "program/metrics.hpp"

#include "vdrive/wire/conversion.hpp"
#include "vdrive_messages_description.hpp"

#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

namespace vdrive::service {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

/// Collects families; every metric carries the number of the bench.
class Families {
 public:
  explicit Families(std::string bench) : bench_(std::move(bench)) {}

  /// Adds a metric to the last family if the name is the same, otherwise to a new family.
  ClientMetric& add(const MetricText& text, MetricType type) {
    if (families_.empty() || families_.back().name != text.name) {
      families_.push_back({.name = std::string(text.name),
                           .help = std::string(text.help),
                           .type = type,
                           .metric = {}});
    }
    ClientMetric& metric = families_.back().metric.emplace_back();
    metric.label.push_back({"bench", bench_});
    if (!text.queue.empty()) metric.label.push_back({"queue", std::string(text.queue)});
    return metric;
  }

  [[nodiscard]] std::vector<MetricFamily> take() { return std::move(families_); }

 private:
  std::string bench_;
  std::vector<MetricFamily> families_;
};

void add_number(Families& families, const MetricText& text, double value) {
  if (text.name.ends_with("_total")) {
    families.add(text, MetricType::Counter).counter.value = value;
  } else {
    families.add(text, MetricType::Gauge).gauge.value = value;
  }
}

template <typename Counted>
double number(const Counted& counted) {
  if constexpr (std::is_arithmetic_v<Counted>) {
    return static_cast<double>(counted);
  } else {
    return static_cast<double>(counted.get());
  }
}

template <typename Source>
void add(Families& families, const MetricRow<Source>& row, const Counters& counters) {
  add_number(families, row.metric, number(std::invoke(row.source, counters)));
}

void add(Families& families, const MetricRow<decltype(Counters::lateness)>& row,
         const Counters& counters) {
  auto& histogram = families.add(row.metric, MetricType::Histogram).histogram;
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

void add(Families& families, const MetricRow<RefusalCounters>& row, const Counters& counters) {
  for (const auto& [reason, count] : counters.refusals.counts()) {
    ClientMetric& metric = families.add(row.metric, MetricType::Counter);
    metric.label.push_back({"reason", wire::describe_reason(reason)});
    metric.counter.value = static_cast<double>(count);
  }
}

/// By the conventions of Prometheus, times are in seconds and names of counters end in _total.
std::string metric_name(const wire::MemberTraits& figure) {
  std::string name = "vdrive_" + std::string(figure.name);
  if (figure.unit == "us" && name.ends_with("_us")) name.replace(name.size() - 3, 3, "_seconds");
  if (figure.figure == wire::FigureKind::counter) name += "_total";
  return name;
}

template <typename Value, typename Source>
void add(Families& families, const FigureRow<Value, Source>& row, const Counters& counters) {
  const wire::MemberTraits& figure = wire::traits_of(row.figure);
  const std::string name = metric_name(figure);
  MetricText text = row.metric;
  if (text.name.empty()) text.name = name;
  if (text.help.empty()) text.help = figure.help;
  const double value = number(counters.*row.source);
  add_number(families, text, figure.unit == "us" ? value / 1.0e6 : value);
}

/// @return how many rows show this member of BenchState.
template <typename Value>
constexpr int rows_of(const wire::Member<msg::BenchState, Value>& figure) {
  return std::apply(
      [&figure](const auto&... rows) {
        const auto shows = [&figure](const auto& row) {
          if constexpr (requires { row.figure == figure.pointer; }) {
            return row.figure == figure.pointer ? 1 : 0;
          } else {
            return 0;
          }
        };
        return (shows(rows) + ...);
      },
      kCounterRows);
}

constexpr bool each_figure_has_one_row() {
  bool has_one = true;
  wire::for_each_figure<msg::BenchState>([&has_one](const auto& figure) {
    has_one = has_one && rows_of(figure) == 1;
  });
  return has_one;
}

static_assert(each_figure_has_one_row(), "each figure of BenchState has one row in kCounterRows");

}  // namespace

Metrics::Metrics(const Configuration& configuration, const BenchIdentity& identity,
                 const Counters& counters)
    : bench_(std::to_string(identity.bench)),
      name_(configuration.name),
      clock_(to_string(configuration.clock)),
      incarnation_(identity.incarnation),
      axes_(configuration.axes.size()),
      counters_(counters) {}

std::vector<MetricFamily> Metrics::Collect() const {
  Families families(bench_);
  ClientMetric& info =
      families.add({"vdrive_info", "1; its labels describe the service"}, MetricType::Gauge);
  info.gauge.value = 1.0;
  info.label.push_back({"name", name_});
  info.label.push_back({"clock", clock_});
  info.label.push_back({"version", VDRIVE_VERSION});
  info.label.push_back({"incarnation", std::to_string(incarnation_)});
  add_number(families, {"vdrive_axes", "Axes of the bench"}, static_cast<double>(axes_));
  std::apply(
      [&](const auto&... rows) {
        (add(families, rows, counters_), ...);
      },
      kCounterRows);
  return families.take();
}

}  // namespace vdrive::service

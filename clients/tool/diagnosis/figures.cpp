// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/measurement.hpp"
#include "terminal/columns.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

namespace vdrive::tool {
namespace {

// Share of late ticks that is tolerated, so that one busy moment of an ordinary machine does not
// count as the limit of its performance.
constexpr double kLateShare = 0.001;

std::string percent(double share) {
  constexpr double kPercent = 100.0;
  return rounded(share * kPercent) + " %";
}

Json lateness_json(const Lateness& lateness) {
  return {{"p50_us", lateness.quantile(0.5)},
          {"p99_us", lateness.quantile(0.99)},
          {"p999_us", lateness.quantile(0.999)},
          {"max_us", lateness.most()}};
}

std::string lateness_line(const std::string& what, const Lateness& lateness) {
  constexpr std::size_t kWhat = 34;
  constexpr std::size_t kFigure = 10;
  std::string line = padded(what, kWhat);
  for (const double share : {0.5, 0.99, 0.999}) {
    line += aligned_right(rounded(lateness.quantile(share)), kFigure);
  }
  return line + aligned_right("< " + rounded(lateness.most()), kFigure);
}

}  // namespace

std::string rounded(double value) {
  if (value == 0.0) return "0";
  constexpr double kHundred = 100.0;
  const int decimals = value >= kHundred ? 0 : value >= 10.0 ? 1 : 2;
  std::array<char, 32> text{};
  const int length = std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return {text.data(), static_cast<std::size_t>(length)};
}

void Lateness::add(std::chrono::nanoseconds late) noexcept {
  const auto microseconds =
      std::max<std::int64_t>(std::chrono::floor<std::chrono::microseconds>(late).count(), 0);
  const auto bin =
      static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(microseconds)));
  ++bins[std::min(bin, bins.size() - 1)];
}

std::uint64_t Lateness::count() const noexcept {
  return std::accumulate(bins.begin(), bins.end(), std::uint64_t{0});
}

double Lateness::quantile(double share) const noexcept {
  const double wanted = share * static_cast<double>(count());
  double below = 0.0;
  for (std::size_t bin = 0; bin < bins.size(); ++bin) {
    const auto in_bin = static_cast<double>(bins[bin]);
    if (in_bin > 0.0 && below + in_bin >= wanted) {
      const double begin = bin == 0 ? 0.0 : std::ldexp(1.0, static_cast<int>(bin) - 1);
      const double end = std::ldexp(1.0, static_cast<int>(bin));
      return begin + (end - begin) * (wanted - below) / in_bin;
    }
    below += in_bin;
  }
  return 0.0;
}

double Lateness::most() const noexcept {
  for (std::size_t bin = bins.size(); bin > 0; --bin) {
    if (bins[bin - 1] != 0) return std::ldexp(1.0, static_cast<int>(bin) - 1);
  }
  return 0.0;
}

bool StatusStreamFigures::is_whole() const noexcept {
  return samples > 0 && missed == 0 && overrun_share <= kLateShare;
}

std::size_t Measurement::axes_of_a_core() const noexcept {
  constexpr double kTick = 1.0e6;
  return tick_of_an_axis > 0.0 ? static_cast<std::size_t>(kTick / tick_of_an_axis) : 0;
}

std::size_t Measurement::axes_with_status() const noexcept {
  std::size_t most = 0;
  for (const StatusStreamFigures& stream : streams) {
    if (stream.is_whole()) most = std::max(most, stream.axes);
  }
  return most;
}

Json measurement_json(const Measurement& measurement) {
  Json streams = Json::array();
  for (const StatusStreamFigures& stream : measurement.streams) {
    streams.push_back({{"axes", stream.axes},
                       {"samples", stream.samples},
                       {"missed", stream.missed},
                       {"overrun_share", stream.overrun_share}});
  }
  return {{"lateness_of_ticks", lateness_json(measurement.ticks)},
          {"lateness_of_a_bare_loop", lateness_json(measurement.bare)},
          {"steps",
           {{"p50_us", measurement.steps.median},
            {"p99_us", measurement.steps.p99},
            {"per_second", measurement.steps.per_second}}},
          {"tick_of_an_axis_ns", measurement.tick_of_an_axis},
          {"axes_of_a_core", measurement.axes_of_a_core()},
          {"status", std::move(streams)},
          {"axes_with_status", measurement.axes_with_status()}};
}

std::vector<std::string> measurement_lines(const Measurement& measurement) {
  const RoundTrips& steps = measurement.steps;
  std::vector<std::string> lines{
      "lateness [us]                            p50       p99     p99.9       max",
      lateness_line("  ticks of a bench, 64 axes", measurement.ticks),
      lateness_line("  a bare loop at the same time", measurement.bare),
      "steps of one tick, 64 axes: p50 " + rounded(steps.median) + " us, p99 " +
          rounded(steps.p99) + " us, " + rounded(steps.per_second) + " a second",
      "tick of a moving axis and its status: " + rounded(measurement.tick_of_an_axis) +
          " ns; one core can run " + std::to_string(measurement.axes_of_a_core()) +
          " axes at 1 kHz",
      "status of all axes at 1 kHz, one client"};
  for (const StatusStreamFigures& stream : measurement.streams) {
    const auto ticks =
        static_cast<double>(std::max<std::uint64_t>(stream.samples + stream.missed, 1));
    constexpr std::size_t kAxes = 8;
    lines.push_back(aligned_right(std::to_string(stream.axes), kAxes) +
                    " axes: " + percent(static_cast<double>(stream.missed) / ticks) +
                    " of the ticks missed, " + percent(stream.overrun_share) + " late");
  }
  const std::size_t held = measurement.axes_with_status();
  lines.push_back(held == 0
                      ? std::string("this machine is too busy even for the smallest number of axes")
                      : "this machine can run " + std::to_string(held) +
                            " axes with every status at 1 kHz");
  return lines;
}

}  // namespace vdrive::tool

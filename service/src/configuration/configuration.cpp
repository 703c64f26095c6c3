// SPDX-License-Identifier: Apache-2.0
#include "configuration/configuration.hpp"

#include "settings/configuration_error.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/wire/address.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/ports.hpp"

#include <algorithm>

namespace vdrive::service {
namespace {

void check_range(const char* what, double value, double lowest, double highest, const char* unit) {
  if (!(value >= lowest && value <= highest)) {
    throw ConfigurationError(std::string(what) + " = " + to_text(value) + ": must be from " +
                             to_text(lowest) + " to " + to_text(highest) + unit);
  }
}

/// Without shared memory the wire runs in threads only in lock-step and freerun, and only if all
/// programs are on this host and need no credentials: programs elsewhere could send data that
/// crashes the wire, and with it the service.
WireForm default_wire_form(const Configuration& configuration) noexcept {
  const wire::NetworkSettings& network = configuration.network;
  if (network.shared_memory) return WireForm::thread;  // the process form must not open files
  // Peers and discovery servers are hosts to send to; the interfaces decide who can send to us.
  const bool is_local = std::ranges::all_of(network.interfaces, &wire::is_loopback);
  const bool needs_process =
      configuration.clock == ClockMode::realtime || !network.security.empty() || !is_local;
  return needs_process ? WireForm::process : WireForm::thread;
}

}  // namespace

Configuration demo_configuration() {
  Configuration configuration;
  configuration.axes = default_axes(2);
  configuration.axes[0].name = "x";
  configuration.axes[1].name = "y";
  return configuration;
}

std::vector<NamedAxis> default_axes(std::size_t count) {
  if (count < 1 || count > kMaxAxes) {
    throw ConfigurationError("axes = " + std::to_string(count) + ": must be from 1 to " +
                             std::to_string(kMaxAxes));
  }
  std::vector<NamedAxis> axes(count);
  for (std::size_t index = 0; index < count; ++index) {
    axes[index].number = static_cast<std::uint16_t>(index + 1);
    axes[index].name = "axis" + std::to_string(index + 1);
  }
  return axes;
}

void check(const Configuration& configuration) {
  check_range("bench", configuration.bench, 1, wire::kHighestBench, "");
  check_range("period", static_cast<double>(configuration.period.count()),
              static_cast<double>(kShortestPeriod.count()),
              static_cast<double>(kLongestPeriod.count()), " us");
  if (configuration.rate != 0.0) {
    check_range("rate", configuration.rate, kLowestRate, kHighestRate, ", or 0 = paused");
  }
  check_range("steppers", configuration.steppers, 0, kMaxSteppers, "");
  check_range("threads", configuration.threads, 1, kMaxThreads, "");
  check_range("domain", configuration.network.domain, 0, wire::kHighestDomain, "");
  check_range("status.every_ticks", configuration.status_every, 1, kMaxStatusEvery, " ticks");
  check_range("axes", static_cast<double>(configuration.axes.size()), 1, kMaxAxes, "");
  if (configuration.wire_form == WireForm::process && configuration.network.shared_memory) {
    throw ConfigurationError(
        "wire.form = process cannot be combined with network.shared_memory = true: the network "
        "process must not open files, and shared memory needs files; use wire.form: thread");
  }
  if (configuration.watchdog) {
    check_range("watchdog", static_cast<double>(configuration.watchdog->count()),
                static_cast<double>(kShortestWatchdog.count()),
                static_cast<double>(kLongestWatchdog.count()), " ms");
  }
}

std::optional<std::string> problem_of_clock(std::string_view key,
                                            const Configuration& configuration) {
  const ClockMode mode = configuration.clock;
  const bool awaits = key == "steppers" && configuration.steppers != 0;
  const bool is_unfit =
      (key == "rate" && mode != ClockMode::realtime) || (awaits && mode != ClockMode::lockstep);
  if (!is_unfit) return std::nullopt;
  const std::string_view how = mode == ClockMode::lockstep  ? "advances only when programs step it"
                               : mode == ClockMode::freerun ? "runs as fast as possible"
                                                            : "runs by the wall clock";
  return std::string(to_string(mode)) + ", which " + std::string(how);
}

std::optional<WireForm> wire_form_named(std::string_view name) noexcept {
  if (name == to_string(WireForm::process)) return WireForm::process;
  return name == to_string(WireForm::thread) ? std::optional(WireForm::thread) : std::nullopt;
}

WireForm effective_wire_form(const Configuration& configuration) noexcept {
  return configuration.wire_form.value_or(default_wire_form(configuration));
}

std::optional<std::chrono::milliseconds> effective_watchdog(
    const Configuration& configuration) noexcept {
  const bool is_default = !configuration.watchdog_is_chosen;
  return configuration.clock == ClockMode::freerun && is_default ? std::nullopt
                                                                 : configuration.watchdog;
}

std::size_t end_of_numbers(const Configuration& configuration) noexcept {
  return configuration.axes.empty() ? 0 : configuration.axes.back().number + std::size_t{1};
}

std::vector<AxisConfiguration> bank_axes(const Configuration& configuration) {
  std::vector<AxisConfiguration> axes;
  axes.reserve(configuration.axes.size());
  for (const auto& axis : configuration.axes) {
    axes.push_back(axis.configuration);
    axes.back().serial_number = configuration.bench * 65'536U + axis.number;
  }
  return axes;
}

}  // namespace vdrive::service

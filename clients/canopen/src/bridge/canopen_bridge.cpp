// SPDX-License-Identifier: Apache-2.0
#include "bridge/canopen_bridge.hpp"

#include "settings/configuration_error.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>

namespace vdrive::canopen {
namespace {

// A new bench is served without noticeable delay, and the search costs the loop little.
constexpr std::chrono::milliseconds kFindBenchesPeriod{200};

// Lower codes are reasons of the wire.
constexpr std::uint32_t kLowestAbortCode = 0x0500'0000;

bench::BenchOptions options_of(const Settings& settings, const BenchSetting& bench) {
  return {.configuration_file = bench.configuration,
          .axes = bench.axes,
          .preset = bench.preset,
          .clock = settings.clock,
          .number = bench.number,
          .state_directory = settings.state,
          .journal = settings.journal};
}

/// @return the benches of a private bridge, all on one local bus; empty if it is not private.
std::vector<bench::Bench> make_private_benches(const Settings& settings) {
  std::vector<bench::Bench> benches;
  if (!settings.is_private) return benches;
  std::shared_ptr<wire::LocalBus> meeting;
  for (const BusSetting& bus : settings.buses) {
    for (const BenchSetting& bench : bus.benches) {
      bench::BenchOptions options = options_of(settings, bench);
      options.bus = meeting;
      benches.emplace_back(options);
      meeting = benches.front().bus();
    }
  }
  return benches;
}

client::SessionOptions session_options(const Settings& settings,
                                       const std::vector<bench::Bench>& benches) {
  client::SessionOptions options = settings.session;
  if (!benches.empty()) options.bus = benches.front().bus();
  return options;
}

}  // namespace

void check_private_benches(const Settings& settings) {
  if (!settings.is_private) return;
  for (const BusSetting& bus : settings.buses) {
    for (const BenchSetting& bench : bus.benches) {
      try {
        bench::check(options_of(settings, bench));
      } catch (const bench::BenchError& error) {
        throw vdrive::settings::ConfigurationError("bench " + std::to_string(bench.number) + ": " +
                                                   error.what());
      }
    }
  }
}

CanopenBridge::CanopenBridge(const Settings& settings)
    : is_private_(settings.is_private),
      benches_(make_private_benches(settings)),
      reports_("vdrive-canopen", {}),
      refused_([this] {
        asio::post(loop_, [this] {
          count_refusals();
        });
      }),
      session_(session_options(settings, benches_)),
      find_timer_(loop_) {
  const BridgeParts shared{
      .loop = loop_, .session = session_, .reports = reports_, .closer = closer_};
  for (const BusSetting& setting : settings.buses) {
    const auto number = static_cast<std::uint16_t>(buses_.size() + 1);
    buses_.push_back(std::make_unique<ServedBus>(shared, settings, setting, number));
  }
  session_.on_event([this](const client::Event& event) {
    // The master gets an abort code in answer to its SDO, and refused values of PDOs are counted
    // one by one.
    if (event.code >= kLowestAbortCode) return;
    const auto text = bridge::refusal_report(event, session_.id());
    if (!text) return;
    reports_.report(bridge::Severity::warning, "bench " + std::to_string(event.bench), *text);
  });
  session_.on_set_point_refusal([this](const client::SetPointRefusal& refusal) {
    refused_.note(refusal);
  });
}

CanopenBridge::~CanopenBridge() {
  // The session must not report to its observers once they are destroyed.
  session_.on_event({});
  session_.on_set_point_refusal({});
  // Ends calls that wait for a bench; the axes are released nevertheless.
  session_.interrupt();
}

void CanopenBridge::start() {
  find();
  while (is_private_ && !are_all_there() && !loop_.stopped()) loop_.run_one();
}

void CanopenBridge::stop() {
  loop_.stop();  // first, so that what ends now is not reported as a lost bench
  session_.interrupt();
}

void CanopenBridge::find() {
  const std::vector<client::BenchInfo> present = session_.present_benches();
  const auto now = ServedBus::Clock::now();
  for (const auto& bus : buses_) bus->find(present, now);
  if (is_private_) {
    // Their axes never change, so a bench left out now will never be served.
    std::vector<std::string> mistakes;
    for (const auto& bus : buses_) {
      for (std::string& reason : bus->left_out()) mistakes.push_back(std::move(reason));
    }
    if (!mistakes.empty()) throw vdrive::settings::ConfigurationError(std::move(mistakes));
  }
  find_later();
}

void CanopenBridge::find_later() {
  find_timer_.expires_after(kFindBenchesPeriod);
  find_timer_.async_wait([this](const AsioError& error) {
    if (!error) find();
  });
}

/// PDOs have no answer, so refused values show only in these counts.
void CanopenBridge::count_refusals() {
  for (const RefusedSetPoints::Count& entry : refused_.take()) {
    for (const auto& bus : buses_) bus->note_refused_set_points(entry.refusal, entry.count);
  }
}

bool CanopenBridge::are_all_there() const {
  return std::ranges::all_of(buses_, [](const auto& bus) {
    return bus->are_all_there();
  });
}

std::vector<std::string> CanopenBridge::first_lines() const {
  std::vector<std::string> lines;
  for (const auto& bus : buses_) {
    lines.push_back(bus->description() + ", session " + session_text(session_.id()));
  }
  return lines;
}

std::vector<std::string> CanopenBridge::counter_lines() const {
  std::vector<std::string> lines;
  for (const auto& bus : buses_) lines.push_back(bus->counters());
  return lines;
}

bool CanopenBridge::flush_logs() {
  bool are_whole = true;
  for (const auto& bus : buses_) are_whole = bus->flush_log() == 0 && are_whole;
  return are_whole;
}

void CanopenBridge::report_library(const std::string& words) {
  reports_.report(bridge::Severity::warning, "network", words);
}

}  // namespace vdrive::canopen

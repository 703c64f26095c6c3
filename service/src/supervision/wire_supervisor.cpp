// SPDX-License-Identifier: Apache-2.0
#include "supervision/wire_supervisor.hpp"

#include "base/event_codes.hpp"
#include "vdrive/wire/participant.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <thread>
#include <utility>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

constexpr auto kLookInterval = 2ms;
constexpr std::size_t kMostNews = 64;

WireLoss loss_of(const WireEnd& end) {
  if (WIFSIGNALED(end.status)) {
    return {.cause = WireLoss::Cause::signal,
            .value = static_cast<std::uint32_t>(WTERMSIG(end.status))};
  }
  return {.cause = WireLoss::Cause::exit_code,
          .value = static_cast<std::uint32_t>(WEXITSTATUS(end.status))};
}

/// Checked during the start, because the signals that end a service are blocked and nothing waits
/// for them yet.
bool has_to_stop() {
  sigset_t pending;
  sigpending(&pending);
  return sigismember(&pending, SIGTERM) == 1 || sigismember(&pending, SIGINT) == 1;
}

std::string error_of(const WireControl& control) {
  const auto* const end = std::ranges::find(control.error, '\0');
  return {control.error.begin(), end};
}

}  // namespace

// ---- supervisor --------------------------------------------------------------------------------

WireSupervisor::WireSupervisor(const WireRegion& region, WireSpawner& spawner,
                               std::uint64_t memory_limit, Counters& counters)
    : region_(region),
      control_(region.control()),
      spawner_(spawner),
      judge_(memory_limit),
      counters_(counters) {}

void WireSupervisor::start() {
  launch(Clock::now());
  while (!is_up_) {
    std::this_thread::sleep_for(kLookInterval);
    if (has_to_stop()) throw wire::NetworkError("stopped by a signal before the wire was ready");
    if (control_.state.load() == WireState::failed) throw wire::NetworkError(error_of(control_));
    if (const auto end = spawner_.next_end()) {
      // The wire writes the reason into the region before it ends.
      const std::string error = error_of(control_);
      throw wire::NetworkError(error.empty() ? "the wire's process: " + loss_of(*end).text()
                                             : error);
    }
    judge(Clock::now());
    if (reason_) throw wire::NetworkError("the wire's process: " + reason_->text());
  }
  news_.clear();
}

void WireSupervisor::launch(Clock::time_point now) {
  next_start_.reset();
  control_.state.store(WireState::starting);
  region_.prepare_for(++generation_);
  is_launched_ = spawner_.launch();
  is_up_ = false;
  reason_.reset();
  judge_.note_start(now);
  counters_.wire_starts.add();
}

void WireSupervisor::supervise() {
  const auto now = Clock::now();
  if (spawner_.is_gone()) {
    is_launched_ = false;
    is_up_ = false;
    counters_.wire_is_up.set(0);
    return;
  }
  if (is_launched_) {
    if (const auto end = spawner_.next_end()) {
      finish(*end, now);
    } else {
      judge(now);
    }
  }
  if (next_start_ && now >= *next_start_) launch(now);
}

/// Counts the wire as lost: its clients cannot be reached any more, whether or not the process has
/// ended yet.
void WireSupervisor::lose(const WireLoss& loss, Clock::time_point now) {
  control_.state.store(WireState::none);
  if (is_up_) lost_at_ = now;
  is_up_ = false;
  counters_.wire_is_up.set(0);
  report(WireCode::kLost, loss);
}

void WireSupervisor::finish(const WireEnd& end, Clock::time_point now) {
  is_launched_ = false;
  if (!reason_) lose(loss_of(end), now);
  next_start_ = judge_.note_end(now, reason_.has_value());
  const auto delay = std::chrono::duration_cast<std::chrono::milliseconds>(*next_start_ - now);
  if (delay > 0ms) report(WireCode::kLater, delay);
}

void WireSupervisor::report(std::uint32_t code, const EventDetail& detail) {
  if (news_.size() < kMostNews) {
    news_.push_back({.kind = msg::EventKind::wire, .code = code, .detail = detail});
  }
}

void WireSupervisor::judge(Clock::time_point now) {
  if (reason_) return;  // it was killed; its end has not been reported yet
  const bool is_running = control_.state.load() == WireState::running;
  counters_.wire_resident.set(control_.resident.load());
  if (is_running && !is_up_) {
    is_up_ = true;
    counters_.wire_is_up.set(1);
    const auto gap = std::chrono::duration_cast<std::chrono::milliseconds>(now - lost_at_);
    report(WireCode::kRuns, gap);
  }
  reason_ = judge_.reason_to_end({.is_running = is_running,
                                  .pump_beats = control_.pump_beats.load(),
                                  .probe_beats = control_.probe_beats.load(),
                                  .resident = control_.resident.load()},
                                 now);
  if (reason_) {
    lose(*reason_, now);
    spawner_.kill();
  } else if (judge_.needs_examination(now)) {
    spawner_.examine();
  }
}

std::optional<EventRecord> WireSupervisor::next_news() {
  if (news_.empty()) return std::nullopt;
  const EventRecord news = news_.front();
  news_.pop_front();
  return news;
}

void WireSupervisor::stop(std::chrono::milliseconds patience) noexcept {
  const auto deadline = Clock::now() + patience;
  control_.stop.store(1);
  Doorbell(control_.reports_bell).ring();
  Doorbell(control_.status_bell).ring();
  while (is_up_ && control_.finished.load() == 0 && Clock::now() < deadline &&
         !spawner_.next_end()) {
    std::this_thread::sleep_for(kLookInterval);
  }
  spawner_.kill();
}

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#include "commands/watch.hpp"

#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "output/watch_view.hpp"
#include "terminal/keys.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/client/step_clock.hpp"

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;
using AxesOfBenches = std::map<std::uint32_t, std::vector<client::AxisId>>;

constexpr std::chrono::milliseconds kPatienceOfWatch{100};

/// A watch with a sample count ends after this wall time without a tick, as a step does.
constexpr std::chrono::milliseconds kLongestStandstill = client::StepClock::kPatience;

/// Takes everything each bench has sent since the last call; waits for a while if there is nothing.
/// @return whether anything has arrived.
client::Result<bool> take_samples(std::vector<client::Follower>& followers, WatchView& view) {
  ensure(!followers.empty(), "a watch has at least one bench");
  const auto patience = kPatienceOfWatch / followers.size();
  bool has_come = false;
  for (client::Follower& follower : followers) {
    auto sample = follower.next(patience);
    // A bench whose time stands still must not delay the samples of others.
    for (; sample; sample = follower.next(std::chrono::milliseconds(0))) {
      view.take(std::move(*sample));
      has_come = true;
    }
    if (sample.outcome().kind() != OutcomeKind::timed_out) return sample.outcome();
  }
  return has_come;
}

/// @return why a bench shows no tick, and how to let its time pass.
std::string why_it_stands(const client::BenchInfo& bench) {
  const std::string name = "bench " + std::to_string(bench.number);
  if (bench.clock_mode == client::ClockMode::lockstep) {
    return name +
           " is in lock-step: its time advances only when a program steps it; step it with 'vdrive "
           "step', or show the present state with 'watch --count 1'";
  }
  if (bench.clock_mode == client::ClockMode::realtime && bench.rate == 0.0) {
    return name + " is paused: 'vdrive rate 1' continues it";
  }
  return name + " sends no status stream";
}

/// @return timed_out, with the reason for each bench.
Outcome no_tick_has_come(const AxesOfBenches& benches, Duration limit, client::Session& session) {
  const auto wall = std::chrono::ceil<std::chrono::milliseconds>(limit);
  std::string text = "no tick has passed within " + std::to_string(wall.count()) + " ms";
  for (const auto& [number, axes] : benches) {
    const auto bench = session.find_bench(number);
    if (!bench) return bench.outcome();
    text += "; " + why_it_stands(*bench);
  }
  return Outcome::timed_out(std::move(text));
}

/// @param keys none if no keys are read
/// @return false if a key ends the view.
bool press_all(std::optional<KeyInput>& keys, WatchView& view) {
  while (const auto key = keys ? keys->next() : std::nullopt) {
    if (!view.press(*key)) return false;
  }
  return true;
}

/// Records whether a tick has arrived. @return whether none has arrived for `limit`.
bool stands(bool has_come, Duration limit, std::chrono::steady_clock::time_point& last_tick) {
  const auto now = std::chrono::steady_clock::now();
  if (has_come) last_tick = now;
  return now - last_tick >= limit;
}

client::Result<std::vector<client::Follower>> follow(const AxesOfBenches& benches, WatchView& view,
                                                     client::Session& session) {
  std::vector<client::Follower> followers;
  followers.reserve(benches.size());
  for (const auto& [bench, ids] : benches) {
    auto follower = session.follow(ids, client::Pace::observe);
    if (!follower) return follower.outcome();
    followers.push_back(std::move(*follower));
    // The first sample is requested, because the stream of a lock-step bench may stand still.
    auto first = session.observe(ids);
    if (first) {
      view.take(std::move(*first));
    } else if (first.outcome().kind() != OutcomeKind::timed_out) {
      return first.outcome();
    }
  }
  return {std::move(followers)};
}

Outcome watch(const AxesOfBenches& benches, WatchView& view, std::uint64_t count,
              const CommandContext& context) {
  auto followers = follow(benches, view, context.session);
  if (!followers) return followers.outcome();
  const Terminal& terminal = context.output.terminal;
  const Duration limit = context.timeout.value_or(kLongestStandstill);
  std::uint64_t shown = 0;
  auto last_tick = std::chrono::steady_clock::now();
  std::optional<KeyInput> keys;
  if (terminal.is_interactive() && count == 0) keys.emplace();
  while (terminal.is_open()) {
    if (!press_all(keys, view)) return {};
    if (view.refresh(std::chrono::steady_clock::now()) && ++shown == count) return {};
    const auto has_come = take_samples(*followers, view);
    if (!has_come) return has_come.outcome();
    // Without a sample count, the user ends the view.
    if (stands(*has_come, limit, last_tick) && count != 0) {
      return no_tick_has_come(benches, limit, context.session);
    }
  }
  return {};
}

}  // namespace

void WatchCommand::declare(Arguments& arguments) {
  arguments.axes(axes, "default: every axis of every bench");
  Argument samples =
      arguments.option("--count", "N", count,
                       "Stop after N samples of each axis; exit code 4 when no tick passes within "
                       "--timeout (wall time, default 10)",
                       parse_count);
  if (arguments.place() == Place::scenario) samples.required();
}

Outcome WatchCommand::run(CommandContext& context) const {
  const auto found = axes.empty() ? context.axes.axes_of_all_benches() : context.axes.axes(axes);
  if (!found) return found.outcome();
  std::map<client::AxisId, AxisLabel> labels;
  AxesOfBenches benches;
  for (const client::Axis& axis : *found) {
    const auto bench = context.session.find_bench(axis.id().bench);
    if (!bench) return bench.outcome();
    labels.emplace(axis.id(), AxisLabel{axis.name(), axis.unit(), bench->name});
    benches[axis.id().bench].push_back(axis.id());
  }
  // Every vdrived has axes: a bench without axes belongs to another program.
  if (benches.empty()) return Outcome::not_found("no bench has an axis");
  using Form = WatchView::Form;
  const bool is_table = context.output.terminal.is_interactive() && count == 0;
  const Form form = is_table ? Form::table : Form::lines;
  WatchView view(context.output.terminal, std::move(labels),
                 context.output.is_json ? Form::json : form);
  return watch(benches, view, count, context);
}

extern const CommandRow kWatch = row_of<WatchCommand>(
    {.name = "watch",
     .group = CommandGroup::observation,
     .summary = "Show axes live until interrupted",
     .example = "watch 1.1 1.2 --count 20\n  vdrive watch          # every axis"});

}  // namespace vdrive::tool

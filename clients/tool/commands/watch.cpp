// SPDX-License-Identifier: Apache-2.0
#include "commands/watch.hpp"

#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "output/watch_view.hpp"
#include "terminal/keys.hpp"
#include "vdrive/assert.hpp"

#include <chrono>
#include <map>
#include <optional>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;
using AxesOfBenches = std::map<std::uint32_t, std::vector<client::AxisId>>;

constexpr std::chrono::milliseconds kPatienceOfWatch{100};

/// Takes what each bench has sent since the last call; waits for a while where nothing has come.
Outcome take_samples(std::vector<client::Follower>& followers, WatchView& view) {
  ensure(!followers.empty(), "a watch has at least one bench");
  const auto patience = kPatienceOfWatch / followers.size();
  for (client::Follower& follower : followers) {
    auto sample = follower.next(patience);
    // A bench whose time stands still must not hold up what the others send.
    for (; sample; sample = follower.next(std::chrono::milliseconds(0))) {
      view.take(std::move(*sample));
    }
    if (sample.outcome().kind() != OutcomeKind::timed_out) return sample.outcome();
  }
  return {};
}

/// @return whether no key ends the view.
bool press_all(KeyInput& keys, WatchView& view) {
  while (const auto key = keys.next()) {
    if (!view.press(*key)) return false;
  }
  return true;
}

client::Result<std::vector<client::Follower>> follow(const AxesOfBenches& benches, WatchView& view,
                                                     client::Session& session) {
  std::vector<client::Follower> followers;
  followers.reserve(benches.size());
  for (const auto& [bench, ids] : benches) {
    auto follower = session.follow(ids, client::Pace::observe);
    if (!follower) return follower.outcome();
    followers.push_back(std::move(*follower));
    // The first sample is a request: the stream of a bench in lock-step may stand still.
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
  std::uint64_t shown = 0;
  std::optional<KeyInput> keys;
  if (terminal.is_interactive() && count == 0) keys.emplace();
  while (terminal.is_open()) {
    if (keys && !press_all(*keys, view)) return {};
    if (view.refresh() && ++shown == count) return {};
    if (Outcome seen = take_samples(*followers, view); !seen) return seen;
  }
  return {};
}

}  // namespace

void WatchCommand::declare(Arguments& arguments) {
  arguments.axes(axes, "default: every axis of every bench");
  Argument samples =
      arguments.option("--count", "N", count, "Stop after N samples of each axis", parse_count);
  if (arguments.place() == Place::scenario) samples.required();
}

Outcome WatchCommand::run(CommandContext& context) const {
  const auto found = axes.empty() ? context.axes.axes_of_all_benches() : context.axes.axes(axes);
  if (!found) return found.outcome();
  std::map<client::AxisId, AxisFace> faces;
  AxesOfBenches benches;
  for (const client::Axis& axis : *found) {
    const auto bench = context.session.find_bench(axis.id().bench);
    if (!bench) return bench.outcome();
    faces.emplace(axis.id(), AxisFace{axis.name(), axis.unit(), bench->name});
    benches[axis.id().bench].push_back(axis.id());
  }
  // What describes itself as a bench without axes is no bench of ours.
  if (benches.empty()) return Outcome::not_found("no bench has an axis");
  using Form = WatchView::Form;
  const bool is_table = context.output.terminal.is_interactive() && count == 0;
  const Form form = is_table ? Form::table : Form::lines;
  WatchView view(context.output.terminal, std::move(faces),
                 context.output.is_json ? Form::json : form);
  return watch(benches, view, count, context);
}

extern const CommandRow kWatch = row_of<WatchCommand>(
    {.name = "watch",
     .summary = "Show axes live until interrupted",
     .example = "watch 1.1 1.2 --count 20\n  vdrive watch          # every axis"});

}  // namespace vdrive::tool

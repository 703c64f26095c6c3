// SPDX-License-Identifier: Apache-2.0
#include "fault_calls.hpp"

#include "vdrive/axis_status.hpp"
#include "vdrive/client/fault_story.hpp"
#include "vdrive/dictionary/object_text.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::gateway {
namespace {

using client::KeptWindow;
using client::Window;
using client::WindowCause;

std::uint32_t bench_of(const Json& request) {
  constexpr NumberRange kBenches{.lowest = 0, .highest = std::numeric_limits<std::uint32_t>::max()};
  const auto number = optional_integer(request, "bench", kBenches);
  if (!number) throw ProtocolError("'bench' is missing: the number of a bench, such as 1");
  return static_cast<std::uint32_t>(*number);
}

client::SessionText session_names_of(client::Session& session, std::uint32_t bench) {
  return [&session, bench](std::uint64_t number) {
    return client::owner_text(number, session.known_name(bench, number));
  };
}

Json cause_json(const WindowCause& cause) {
  return {{"kind", to_string(cause.kind)},
          {"axis", cause.axis},
          {"code", cause.code},
          {"tick", cause.tick}};
}

Json window_json(const KeptWindow& window) {
  Json causes = Json::array();
  for (const WindowCause& cause : window.causes) causes.push_back(cause_json(cause));
  return {{"window", window.number},           {"first_tick", window.first_tick},
          {"last_tick", window.last_tick},     {"is_open", window.is_open},
          {"more_causes", window.more_causes}, {"causes", std::move(causes)}};
}

Json story_json(const client::FaultStory& story) {
  return {{"title", story.title}, {"lines", story.lines}, {"remedy", story.remedy}};
}

std::string text_of_write(const client::AxisWrite& write) {
  using Kind = client::AxisWrite::Kind;
  if (write.kind == Kind::power_cycle) return "power cycle";
  if (write.kind == Kind::connection_loss) return "its master fell silent";
  return object_text(write.object) + " = " + std::to_string(write.value);
}

Json write_json(const client::AxisWrite& write, const client::SessionText& name) {
  return {{"tick", write.tick},
          {"text", text_of_write(write)},
          {"refused", write.reason != 0},
          {"by", write.session == 0 ? std::string() : name(write.session)}};
}

/// The samples of one axis: a list of ticks and, for each member of the status, a list of numbers
/// of the same length.
Json samples_json(const Window& window) {
  Json ticks = Json::array();
  Json series = Json::object();
  for (const client::Observation& sample : window.samples) {
    ticks.push_back(sample.tick);
    for (const StatusMember& member : status_members()) {
      if (!member.is_published) continue;
      series[std::string(member.name)].push_back(member.value(sample.axes.front().status));
    }
  }
  series["tick"] = std::move(ticks);
  return series;
}

}  // namespace

CallAnswer call_freeze(client::Session& session, const Json& request) {
  const auto number = session.freeze_window(bench_of(request));
  if (!number) return {.outcome = number.outcome()};
  return {.outcome = {}, .fields = {{"window", *number}}};
}

CallAnswer call_faults(client::Session& session, const Json& request) {
  const auto windows = session.windows(bench_of(request));
  if (!windows) return {.outcome = windows.outcome()};
  Json list = Json::array();
  for (const KeptWindow& window : *windows) list.push_back(window_json(window));
  return {.outcome = {}, .fields = {{"windows", std::move(list)}}};
}

CallAnswer call_fault(client::Session& session, const Json& request) {
  constexpr NumberRange kWindows{.lowest = 1, .highest = std::numeric_limits<std::int64_t>::max()};
  const auto number = optional_integer(request, "window", kWindows);
  if (!number) throw ProtocolError("'window' is missing: the number of a window, from /faults");
  const Json& name = member(request, "axis");
  if (!name.is_string()) throw ProtocolError(R"('axis' must be a string, such as "1.2")");
  const auto axis = session.axis(name.get<std::string>());
  if (!axis) return {.outcome = axis.outcome()};
  const auto bench = session.find_bench(axis->id().bench);
  if (!bench) return {.outcome = bench.outcome()};
  const std::array ids{axis->id()};
  const auto window = session.window(static_cast<std::uint64_t>(*number), ids);
  if (!window) return {.outcome = window.outcome()};
  const client::SessionText named = session_names_of(session, bench->number);
  Json stories = Json::array();
  for (const WindowCause& cause : window->kept.causes) {
    const bool is_about_it = cause.axis == 0 || cause.axis == axis->id().axis;
    if (is_about_it) stories.push_back(story_json(story_of(*window, cause, *bench, named)));
  }
  Json writes = Json::array();
  for (const client::AxisWrite& write : window->writes) writes.push_back(write_json(write, named));
  return {.outcome = {},
          .fields = {{"kept", window_json(window->kept)},
                     {"stories", std::move(stories)},
                     {"writes", std::move(writes)},
                     {"samples", samples_json(*window)}}};
}

}  // namespace vdrive::gateway

// SPDX-License-Identifier: Apache-2.0
#include "output/event_view.hpp"

#include "output/record.hpp"
#include "vdrive/bounded_queue.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <set>
#include <string_view>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Event;
using client::EventKind;
using client::EventSeverity;
using Clock = std::chrono::steady_clock;

// Kept events arrive in one burst once the reader is matched; nothing marks its end.
constexpr std::chrono::milliseconds kQuiet{500};
constexpr std::chrono::seconds kLongest{5};
constexpr std::chrono::seconds kLongestOfFollower{1};  // kLongest would delay new events too long
constexpr std::chrono::milliseconds kPeriod{50};       // an interrupt does not wake the queue

// A stopped terminal takes no lines; waiting events must not fill the memory.
constexpr std::size_t kMostEvents = 1'000'000;

/// Passes events from the thread of the session.
class EventQueue {
 public:
  void push(const Event& event) {
    const std::scoped_lock lock(mutex_);
    events_.put(event);
    arrived_.notify_one();
  }

  /// @return the number dropped so far.
  [[nodiscard]] std::uint64_t dropped() const {
    const std::scoped_lock lock(mutex_);
    return events_.dropped();
  }

  std::optional<Event> next(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    const bool has_one = arrived_.wait_for(lock, patience, [this] {
      return !events_.empty();
    });
    if (!has_one) return std::nullopt;
    return events_.take();
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  BoundedQueue<Event> events_{kMostEvents, WhenFull::drops_oldest};
};

/// The names of sessions in events.
class EventNames {
 public:
  explicit EventNames(client::Session& session) : session_(session) {}

  /// Waits for a name that is asked for the first time, at most one second in total for unknown
  /// ones: a program of another vendor publishes none.
  std::optional<client::SessionName> find(std::uint32_t bench, std::uint64_t session) {
    if (session == 0) return std::nullopt;
    auto name = session_.known_name(bench, session);
    const bool waits = !name && left_.count() > 0 && asked_.emplace(bench, session).second;
    if (!waits) return name;
    const auto begin = Clock::now();
    name = session_.find_name(bench, session);
    if (!name) left_ -= Clock::now() - begin;
    return name;
  }

 private:
  client::Session& session_;
  std::set<std::pair<std::uint32_t, std::uint64_t>> asked_;
  Clock::duration left_ = std::chrono::seconds(1);
};

/// @return the text with the session's name before its number.
std::string with_session_names(std::string text, std::uint32_t bench,
                               const SessionNameOf& name_of) {
  constexpr std::string_view kSession = "session 0x";
  constexpr std::size_t kDigits = 16;
  for (std::size_t at = text.find(kSession); at != std::string::npos;) {
    const std::size_t length = kSession.size() + kDigits;
    const auto session = parse_digits<std::uint64_t>(
        std::string_view(text).substr(at, length).substr(kSession.size()), 16);
    const auto name = session ? name_of(bench, *session) : std::nullopt;
    const std::string shown = name ? client::owner_text(*session, name) : text.substr(at, length);
    text.replace(at, length, shown);
    at = text.find(kSession, at + shown.size());
  }
  return text;
}

Json event_json(const Event& event, const SessionNameOf& name_of) {
  return {{"bench", event.bench},
          {"axis", event.axis == 0 ? Json(nullptr)
                                   : Json(to_string(client::AxisId{event.bench, event.axis}))},
          {"tick", event.tick},
          {"kind", to_string(event.kind)},
          {"code", event.code},
          {"error_register", event.error_register},
          {"session", session_json(event.session)},
          {"session_name", name_json(name_of(event.bench, event.session))},
          {"suppressed", event.suppressed},
          {"text", event.text}};
}

std::optional<Color> color_of(EventKind kind) {
  switch (severity_of(kind)) {
    case EventSeverity::error:
      return Color::red;
    case EventSeverity::warning:
      return Color::yellow;
    case EventSeverity::info:
      break;
  }
  return std::nullopt;
}

bool is_chosen(const EventChoice& choice, const Event& event) {
  if (choice.axis) return event.bench == choice.axis->bench && event.axis == choice.axis->axis;
  return !choice.bench || *choice.bench == event.bench;
}

void print(const Event& event, bool is_json, const SessionNameOf& name_of, Terminal& terminal) {
  if (is_json) {
    terminal.print(to_line(event_json(event, name_of)));
    return;
  }
  const auto color = color_of(event.kind);
  const std::string text = event_text(event, name_of);
  terminal.print(color ? colored(terminal, *color, text) : text);
}

/// Passes on the events that the benches keep, sorted by tick. If `follow` is set, also passes on
/// later events as long as `goes_on` returns true.
template <typename GoesOn, typename Take>
std::uint64_t take_events(client::Session& session, bool follow, const GoesOn& goes_on,
                          const Take& take) {
  EventQueue queue;
  session.on_event(
      [&queue](const Event& event) {
        queue.push(event);
      },
      client::EventHistory::kept);
  // The network preserves the order only within one kind of event.
  std::vector<Event> kept;
  const auto begin = Clock::now();
  auto last = begin;
  // A bench that reports events all the time is never quiet.
  const auto end = begin + (follow ? kLongestOfFollower : kLongest);
  while (goes_on() && last < end && Clock::now() - last <= kQuiet) {
    if (auto event = queue.next(kPeriod)) {
      kept.push_back(*std::move(event));
      last = Clock::now();
    }
  }
  std::ranges::stable_sort(kept, {}, &Event::tick);
  std::ranges::for_each(kept, take);
  while (follow && goes_on()) {
    if (const auto event = queue.next(kPeriod)) take(*event);
  }
  session.on_event(nullptr);
  return queue.dropped();
}

}  // namespace

std::string event_text(const Event& event, const SessionNameOf& name_of) {
  const std::string who = event.axis == 0 ? "bench " + std::to_string(event.bench)
                                          : to_string(client::AxisId{event.bench, event.axis});
  // The text of the bench starts with the axis number.
  const std::string prefix = "axis " + std::to_string(event.axis) + ": ";
  std::string text = event.text;
  if (event.axis != 0 && text.starts_with(prefix)) text.erase(0, prefix.size());
  std::string line = std::to_string(event.tick) + "  " + who + "  " +
                     with_session_names(escaped(text, kShownOfMessage), event.bench, name_of);
  if (event.suppressed != 0) {
    line += " (" + counted(event.suppressed, "equal event", "equal events") + " suppressed)";
  }
  return line;
}

client::Outcome show_events(client::Session& session, const EventChoice& choice,
                            Terminal& terminal) {
  const auto goes_on = [&] {
    return terminal.is_open() && !session.is_interrupted();
  };
  EventNames names(session);
  const SessionNameOf name_of = [&names](std::uint32_t bench, std::uint64_t number) {
    return names.find(bench, number);
  };
  const auto dropped = take_events(session, choice.follow, goes_on, [&](const Event& event) {
    if (is_chosen(choice, event)) print(event, choice.is_json, name_of, terminal);
  });
  if (dropped > 0) {
    terminal.print_error("vdrive: " + counted(dropped, "event was", "events were") +
                         " dropped: they arrived faster than they could be printed");
  }
  return {};
}

std::vector<Event> kept_events(client::Session& session) {
  std::vector<Event> events;
  const auto goes_on = [&session] {
    return !session.is_interrupted();
  };
  (void)take_events(session, false, goes_on, [&events](const Event& event) {
    events.push_back(event);
  });
  return events;
}

std::optional<std::uint64_t> tick_of_fault(const std::vector<Event>& events,
                                           const client::AxisId& axis, std::uint16_t code) {
  std::optional<std::uint64_t> tick;
  for (const Event& event : events) {
    const bool is_it = event.kind == EventKind::fault && event.bench == axis.bench &&
                       event.axis == axis.axis && event.code == code;
    if (is_it) tick = event.tick;
  }
  return tick;
}

}  // namespace vdrive::tool

// SPDX-License-Identifier: Apache-2.0
// The history kept by a bench: snapshots, writes, windows.
#include "vdrive/client/history.hpp"

#include "base/ask.hpp"
#include "session/session_core.hpp"
#include "streams/status_feed.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/written.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using wire::WrittenMark;

/// Sends a request that concerns the whole bench, such as one about its snapshots or windows.
/// @param what names the subject in messages, such as "snapshot 1"
Result<RequestAnswer> exchange_with_bench(SessionCore& core, std::uint32_t bench,
                                          msg::Request request,
                                          const std::string& what = "snapshot") {
  const auto target = core.links.connect(bench);
  if (!target) return target.outcome();
  auto reply = core.control.exchange(*target, std::move(request), what + " of " + name_of(*target));
  if (!reply) return core.names.with_session_name(*target, reply.outcome());
  return reply;
}

WrittenMark mark_of(const msg::ObjectResult& entry) {
  return static_cast<WrittenMark>(entry.subindex);
}

/// The answer lists marks between the writes. Some stand for an event; the others give the tick or
/// the author of the writes that follow: takes these into `next`.
void take_context(const msg::ObjectResult& mark, AxisWrite& next) {
  const auto value = static_cast<std::uint64_t>(mark.value);
  switch (mark_of(mark)) {
    case WrittenMark::tick:
      next.tick = value;
      break;
    case WrittenMark::by_request:
      next.means = AxisWrite::Means::request;
      next.session = value;
      break;
    case WrittenMark::by_frame:
      next.means = AxisWrite::Means::frame;
      next.session = value;
      break;
    case WrittenMark::by_bench:
      next.means = AxisWrite::Means::bench;
      next.session = 0;
      break;
    default:  // another kind of mark, or one of a later version
      break;
  }
}

/// @return the event, other than a write, that the mark stands for; nothing for any other mark.
std::optional<AxisWrite::Kind> kind_of(WrittenMark mark) {
  switch (mark) {
    case WrittenMark::lost:
      return AxisWrite::Kind::lost;
    case WrittenMark::restored:
      return AxisWrite::Kind::restored;
    case WrittenMark::power_cycle:
      return AxisWrite::Kind::power_cycle;
    case WrittenMark::connection_loss:
      return AxisWrite::Kind::connection_loss;
    default:
      return std::nullopt;
  }
}

/// @param next the tick and the author of the following entries
AxisWrite write_of(const msg::ObjectResult& entry, const AxisWrite& next) {
  AxisWrite write = next;
  write.axis = entry.axis;
  write.object = {entry.index, entry.subindex};
  write.value = entry.value;
  write.reason = wire::number(entry.abort_code);
  write.is_late = entry.abort_code == msg::Reason::too_late;
  return write;
}

AxisWrite happening_of(AxisWrite::Kind kind, const msg::ObjectResult& mark, const AxisWrite& next) {
  AxisWrite happened = next;
  happened.kind = kind;
  happened.axis = mark.axis;
  happened.value = mark.value;
  return happened;
}

std::optional<WindowCause::Kind> cause_of(WrittenMark mark) {
  switch (mark) {
    case WrittenMark::fault:
      return WindowCause::Kind::fault;
    case WrittenMark::master_lost:
      return WindowCause::Kind::master_lost;
    case WrittenMark::stopped:
      return WindowCause::Kind::stopped;
    case WrittenMark::asked:
      return WindowCause::Kind::asked;
    default:
      return std::nullopt;
  }
}

KeptWindow window_of(const msg::Reply& reply) {
  KeptWindow window{.number = reply.snapshot, .last_tick = reply.tick};
  std::uint64_t session = 0;
  for (const msg::ObjectResult& entry : reply.objects) {
    const WrittenMark mark = mark_of(entry);
    const auto value = static_cast<std::uint64_t>(entry.value);
    if (const auto kind = cause_of(mark)) {
      window.causes.push_back({.kind = *kind,
                               .axis = entry.axis,
                               .code = wire::number(entry.abort_code),
                               .session = std::exchange(session, 0),
                               .tick = value});
    } else if (mark == WrittenMark::tick) {
      window.first_tick = value;
    } else if (mark == WrittenMark::of_session) {
      session = value;
    } else if (mark == WrittenMark::more_causes) {
      window.more_causes = value;
    } else if (mark == WrittenMark::open) {
      window.is_open = true;
      window.last_tick = value;
    }
  }
  return window;
}

/// @return the break that a mark stands for; nothing for any other mark.
std::optional<WindowBreak::Kind> break_of(WrittenMark mark) {
  switch (mark) {
    case WrittenMark::restored:
      return WindowBreak::Kind::restored;
    case WrittenMark::jumped:
      return WindowBreak::Kind::jumped;
    case WrittenMark::resumed:
      return WindowBreak::Kind::missing;
    default:
      return std::nullopt;
  }
}

/// @return refused if there is no such window.
Result<KeptWindow> kept_window(SessionCore& core, std::uint32_t bench, std::uint64_t number) {
  const auto next = exchange_with_bench(core, bench, ask::next_window(number - 1), "windows");
  if (!next) return next.outcome();
  KeptWindow window = window_of(*next);
  if (next->snapshot == number && !window.causes.empty()) return window;
  return Outcome::refused(
      wire::number(msg::Reason::unknown_window),
      "bench " + std::to_string(bench) + " does not keep window " + std::to_string(number));
}

/// Waits until the bench has recorded the end of a window. Does not wait in lock-step or for a
/// paused bench.
Outcome wait_for_end(SessionCore& core, std::uint32_t bench, std::uint64_t number) {
  const auto target = core.links.connect(bench);
  if (!target) return target.outcome();
  while (true) {  // a further cause extends the window
    const auto kept = kept_window(core, bench, number);
    if (!kept || !kept->is_open || target->steps() || core.discovery.is_paused(target->key)) {
      return kept.outcome();
    }
    const auto reached = core.observer.wait_for_tick(*target, kept->last_tick);
    if (!reached) return reached.outcome();
  }
}

/// Assembles the pages of a window.
class WindowReader {
 public:
  void take(const RequestAnswer& page, std::size_t axes) {
    are_values_ = false;
    for (const msg::ObjectResult& entry : page.objects) {
      if (entry.index != 0) {
        take_object(entry);
      } else {
        take_mark(entry);
      }
    }
    for (const wire::ReceivedStatus& status : page.axes) take_status(status, axes);
  }

  [[nodiscard]] Window window_of(KeptWindow kept) && {
    window_.kept = std::move(kept);
    return std::move(window_);
  }

 private:
  void take_object(const msg::ObjectResult& entry) {
    if (are_values_) {
      window_.values.push_back({.tick = next_.tick,
                                .axis = entry.axis,
                                .object = {entry.index, entry.subindex},
                                .value = entry.value});
    } else {
      window_.writes.push_back(write_of(entry, next_));
    }
  }

  void take_mark(const msg::ObjectResult& mark) {
    const WrittenMark kind = mark_of(mark);
    if (kind == WrittenMark::began || break_of(kind)) {
      take_state(break_of(kind));
    } else if (kind == WrittenMark::of_session) {
      session_ = static_cast<std::uint64_t>(mark.value);
    } else if (kind == WrittenMark::event) {
      window_.events.push_back({.tick = next_.tick,
                                .kind = static_cast<EventKind>(mark.value),
                                .axis = mark.axis,
                                .session = std::exchange(session_, 0),
                                .code = wire::number(mark.abort_code)});
    } else if (const auto happened = kind_of(kind)) {
      window_.writes.push_back(happening_of(*happened, mark, next_));
    } else {
      are_values_ = false;
      take_context(mark, next_);
    }
  }

  /// Starts a list of values. The beginning of a window is not a break.
  void take_state(std::optional<WindowBreak::Kind> kind) {
    are_values_ = true;
    const bool is_beginning = !std::exchange(has_begun_, true);
    if (kind && !is_beginning) window_.breaks.push_back({.kind = *kind, .tick = next_.tick});
  }

  void take_status(const wire::ReceivedStatus& status, std::size_t axes) {
    if (window_.samples.empty() || window_.samples.back().axes.size() == axes) {
      window_.samples.emplace_back().tick = status.tick;
    }
    AxisSnapshot& axis = window_.samples.back().axes.emplace_back();
    fill_sample(status, axis);
    axis.has_owner = false;
  }

  Window window_;
  AxisWrite next_;             ///< tick and author of the following entries
  std::uint64_t session_ = 0;  ///< of the next event
  bool has_begun_ = false;     ///< a state has been received
  bool are_values_ = false;    ///< the following entries are values, not writes
};

}  // namespace

std::string_view to_string(WindowCause::Kind kind) noexcept {
  switch (kind) {
    case WindowCause::Kind::fault:
      return "fault";
    case WindowCause::Kind::master_lost:
      return "master lost";
    case WindowCause::Kind::stopped:
      return "stopped by another session";
    case WindowCause::Kind::asked:
      break;
  }
  return "asked for";
}

Result<std::uint64_t> Session::take_snapshot(std::uint32_t bench) {
  const auto reply = exchange_with_bench(*core_, bench, ask::take_snapshot());
  if (!reply) return reply.outcome();
  return reply->snapshot;
}

Result<std::uint64_t> Session::restore_snapshot(std::uint32_t bench, std::uint64_t snapshot) {
  const auto reply = exchange_with_bench(*core_, bench, ask::restore_snapshot(snapshot),
                                         "snapshot " + std::to_string(snapshot));
  if (!reply) return reply.outcome();
  return reply->tick;
}

Result<std::vector<KeptSnapshot>> Session::snapshots(std::uint32_t bench) {
  std::vector<KeptSnapshot> kept;
  while (true) {
    const std::uint64_t snapshot = kept.empty() ? 0 : kept.back().number;
    const auto next = exchange_with_bench(*core_, bench, ask::next_snapshot(snapshot));
    if (!next) return next.outcome();
    // If a service counted backwards, the list would never end.
    if (next->snapshot <= snapshot) return kept;
    kept.push_back({.number = next->snapshot, .tick = next->tick});
  }
}

Outcome Session::drop_snapshot(std::uint32_t bench, std::uint64_t snapshot) {
  return exchange_with_bench(*core_, bench, ask::drop_snapshot(snapshot),
                             "snapshot " + std::to_string(snapshot))
      .outcome();
}

Result<AxisWrites> Session::writes(std::uint32_t bench, std::uint64_t place) {
  const auto reply = exchange_with_bench(*core_, bench, ask::read_writes(place), "writes");
  if (!reply) return reply.outcome();
  AxisWrites read{.writes = {}, .place = reply->snapshot, .tick = reply->tick};
  AxisWrite next;
  for (const msg::ObjectResult& entry : reply->objects) {
    if (entry.index != 0) {
      read.writes.push_back(write_of(entry, next));
    } else if (const auto kind = kind_of(mark_of(entry))) {
      read.writes.push_back(happening_of(*kind, entry, next));
    } else {
      take_context(entry, next);
    }
  }
  return read;
}

Result<std::vector<KeptWindow>> Session::windows(std::uint32_t bench) {
  std::vector<KeptWindow> kept;
  while (true) {
    const std::uint64_t number = kept.empty() ? 0 : kept.back().number;
    const auto next = exchange_with_bench(*core_, bench, ask::next_window(number), "windows");
    if (!next) return next.outcome();
    if (next->snapshot <= number) return kept;  // 0 = the end; counting backwards would never end
    kept.push_back(window_of(*next));
    if (kept.back().causes.empty()) return Outcome::failed("a window of the bench has no cause");
  }
}

Result<std::uint64_t> Session::freeze_window(std::uint32_t bench) {
  const auto reply = exchange_with_bench(*core_, bench, ask::freeze_window(), "window");
  if (!reply) return reply.outcome();
  return reply->snapshot;
}

Result<Window> Session::window(std::uint64_t number, std::span<const AxisId> axes) {
  const auto numbers = numbers_of(axes);
  if (!numbers) return numbers.outcome();
  const std::uint32_t bench = axes.front().bench;
  const std::string what = "window " + std::to_string(number);
  if (Outcome ended = wait_for_end(*core_, bench, number); !ended) return ended;
  WindowReader reader;
  std::uint64_t place = 0;
  do {
    const auto page =
        exchange_with_bench(*core_, bench, ask::read_window(number, *numbers, place), what);
    if (!page) return page.outcome();
    reader.take(*page, numbers->size());
    // If a service counted backwards, the window would never end.
    if (page->snapshot != 0 && page->snapshot <= place) {
      return Outcome::failed(what + ": the bench sent the same page twice");
    }
    place = page->snapshot;
  } while (place != 0);
  const auto kept = kept_window(*core_, bench, number);
  if (!kept) return kept.outcome();
  return std::move(reader).window_of(*kept);
}

}  // namespace vdrive::client

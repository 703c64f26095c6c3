// SPDX-License-Identifier: Apache-2.0
#include "engine/windows.hpp"

#include "engine/history_marks.hpp"

#include <atomic>
#include <span>

namespace vdrive::service {
namespace {

using wire::WrittenMark;

WrittenMark mark_of(WindowCause::Kind kind) {
  switch (kind) {
    case WindowCause::Kind::fault:
      return WrittenMark::fault;
    case WindowCause::Kind::master_lost:
      return WrittenMark::master_lost;
    case WindowCause::Kind::stopped:
      return WrittenMark::stopped;
    case WindowCause::Kind::asked:
      break;
  }
  return WrittenMark::asked;
}

}  // namespace

Reason Windows::freeze(const msg::Request& request, msg::Reply& reply) {
  reply.snapshot =
      axes_.black_box().freeze({.kind = WindowCause::Kind::asked, .session = request.session});
  return reply.snapshot == 0 ? msg::Reason::no_black_box : msg::Reason::none;
}

Reason Windows::show_next(const msg::Request& request, msg::Reply& reply) const {
  const BlackBox& box = axes_.black_box();
  if (!box.is_on()) return msg::Reason::no_black_box;
  const Window* const window = box.next_window(request.snapshot);
  if (window == nullptr) return msg::Reason::none;
  reply.snapshot = window->number;
  // The end of an open window has not happened yet, so `tick` cannot contain it.
  reply.tick = window->last_tick;
  add_mark(WrittenMark::tick, window->first_tick, reply);
  if (box.is_open(*window)) add_mark(WrittenMark::open, box.end_of_open(), reply);
  for (const WindowCause& cause : std::span(window->causes).first(window->cause_count)) {
    if (cause.session != 0) add_mark(WrittenMark::of_session, cause.session, reply);
    auto& entry = add_mark(mark_of(cause.kind), cause.tick, reply);
    entry.axis = cause.axis;
    entry.abort_code = static_cast<msg::Reason>(cause.code);
  }
  if (window->more_causes > 0) add_mark(WrittenMark::more_causes, window->more_causes, reply);
  return msg::Reason::none;
}

const Window* Windows::find(std::uint64_t number) const noexcept {
  if (number == 0) return nullptr;
  const Window* const window = axes_.black_box().next_window(number - 1);
  return window != nullptr && window->number == number ? window : nullptr;
}

Reason Windows::read(const msg::Request& request, msg::Reply& reply) {
  BlackBox& box = axes_.black_box();
  if (!box.is_on()) return msg::Reason::no_black_box;
  if (request.axes.empty()) return msg::Reason::nothing_done;
  // Limits the wait: an answer is sent after all pages ordered before it.
  constexpr std::uint32_t kMostPages = 4;
  if (box.pages_waiting.load(std::memory_order_relaxed) >= kMostPages) {
    return msg::Reason::queue_full;
  }
  auto page = std::make_unique<WindowPage>();
  for (const std::uint16_t number : request.axes) {
    const auto axis = axes_.index_of(number);
    if (!axis) {
      reply.refused_axis = number;
      return msg::Reason::unknown_axis;
    }
    page->axes.push_back(*axis);
  }
  const Window* window = find(request.snapshot);
  if (window != nullptr && box.is_open(*window)) {
    if (!clock_.time_stands()) return msg::Reason::window_is_open;
    box.end_window(axes_.bank());
    window = find(request.snapshot);
  }
  if (window == nullptr) return msg::Reason::unknown_window;
  page->window = *window;
  page->place = request.ticks;
  box.hold(page->window);
  box.pages_waiting.fetch_add(1, std::memory_order_relaxed);
  reply.tick = window->last_tick;
  page_ = std::move(page);
  return msg::Reason::none;
}

}  // namespace vdrive::service

// SPDX-License-Identifier: Apache-2.0
#include "engine/request_handlers.hpp"

#include "base/event_record.hpp"
#include "configuration/configuration.hpp"
#include "vdrive/wire/request_kinds.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace vdrive::service {
namespace {

template <typename Function, typename Part>
Part& part_of(Function Part::* /*function*/, const RequestParts& parts) {
  return std::get<Part&>(parts);
}

/// The handler of a kind that is carried out by a member function of one of the parts.
template <auto kFunction>
Reason pass_on(const RequestParts& parts, const msg::Request& request, msg::Reply& reply) {
  return (part_of(kFunction, parts).*kFunction)(request, reply);
}

Reason power_cycle(const RequestParts& parts, const msg::Request& request, msg::Reply& reply) {
  const Reason refusal = std::get<Masters&>(parts).check_axes(request, false, reply);
  if (refusal != msg::Reason::none) return refusal;
  auto& axes = std::get<BenchAxes&>(parts);
  for (const std::uint16_t number : request.axes) {
    std::get<FrameSchedule&>(parts).cancel_of_axis(number);
    axes.power_cycle(axes.index_of_checked(number));
  }
  reply.tick = std::get<BenchClock&>(parts).next_tick();
  return msg::Reason::none;
}

/// Any session may set the rate, because time is shared by all.
Reason set_rate(const RequestParts& parts, const msg::Request& request, msg::Reply& /*reply*/) {
  const double rate = request.rate;
  if (!(rate == 0.0 || (rate >= kLowestRate && rate <= kHighestRate))) {  // refuses NaN, too
    return msg::Reason::out_of_range;
  }
  auto& clock = std::get<BenchClock&>(parts);
  if (rate == clock.rate()) return msg::Reason::none;
  clock.set_rate(rate);
  std::get<MasterWatch&>(parts).follow_rate();
  std::get<BenchEvents&>(parts).report({.kind = msg::EventKind::clock_changed,
                                        .session = request.session,
                                        .code = wire::number(msg::RequestKind::set_rate),
                                        .detail = NewRate{clock.rate()}});
  return msg::Reason::none;
}

Reason read_writes(const RequestParts& parts, const msg::Request& request, msg::Reply& reply) {
  return std::get<BenchAxes&>(parts).writes().read(request, reply);
}

struct HandlerRow {
  msg::RequestKind kind;
  RequestHandler handler;
};

constexpr std::array kHandlers{
    HandlerRow{msg::RequestKind::read, pass_on<&AxisRequests::read>},
    HandlerRow{msg::RequestKind::write, pass_on<&AxisRequests::write>},
    HandlerRow{msg::RequestKind::store, pass_on<&StoreRequests::store_axes>},
    HandlerRow{msg::RequestKind::restore, pass_on<&StoreRequests::store_axes>},
    HandlerRow{msg::RequestKind::acquire, pass_on<&Masters::acquire>},
    HandlerRow{msg::RequestKind::take_over, pass_on<&Masters::acquire>},
    HandlerRow{msg::RequestKind::release, pass_on<&Masters::release>},
    HandlerRow{msg::RequestKind::power_cycle, power_cycle},
    HandlerRow{msg::RequestKind::set_rate, set_rate},
    HandlerRow{msg::RequestKind::take_snapshot, pass_on<&Snapshots::take>},
    HandlerRow{msg::RequestKind::restore_snapshot, pass_on<&Snapshots::restore>},
    HandlerRow{msg::RequestKind::drop_snapshot, pass_on<&Snapshots::drop>},
    HandlerRow{msg::RequestKind::next_snapshot, pass_on<&Snapshots::show_next>},
    HandlerRow{msg::RequestKind::read_writes, read_writes},
    HandlerRow{msg::RequestKind::freeze_window, pass_on<&Windows::freeze>},
    HandlerRow{msg::RequestKind::next_window, pass_on<&Windows::show_next>},
    HandlerRow{msg::RequestKind::read_window, pass_on<&Windows::read>},
};

constexpr RequestHandler find_handler(msg::RequestKind kind) noexcept {
  const auto row = std::ranges::find(kHandlers, kind, &HandlerRow::kind);
  return row == kHandlers.end() ? nullptr : row->handler;
}

static_assert(std::ranges::all_of(wire::kRequestKinds,
                                  [](const wire::RequestKindRow& row) {
                                    const bool is_of_a_stepper =
                                        row.caller == wire::RequestCaller::stepper;
                                    return (find_handler(row.kind) != nullptr) != is_of_a_stepper;
                                  }),
              "each kind of request has one handler: here, or those of steppers in StepRequests");

}  // namespace

RequestHandler handler_of(msg::RequestKind kind) noexcept {
  return find_handler(kind);
}

}  // namespace vdrive::service

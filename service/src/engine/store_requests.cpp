// SPDX-License-Identifier: Apache-2.0
#include "engine/store_requests.hpp"

#include "base/event_codes.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;

constexpr std::size_t kNoObject = msg::MAX_OBJECTS_PER_REQUEST;
constexpr std::size_t kMostWaiting = 1'024;
// All orders of a batch become durable together; each tick handles only a few, so that no tick is
// late.
constexpr std::size_t kOrdersPerTick = 4;

}  // namespace

StoreRequests::StoreRequests(BenchAxes& axes, const BenchClock& clock, const Masters& masters,
                             RequestAnswers& answers, BenchEvents& events,
                             Ring<OutgoingReply>& queue, Counters& counters)
    : axes_(axes),
      clock_(clock),
      masters_(masters),
      answers_(answers),
      events_(events),
      queue_(queue),
      counters_(counters) {}

void StoreRequests::store_with(ParameterSaver& saver) {
  saver_ = &saver;
  waiting_.resize(kMostWaiting);
  free_places_.reserve(kMostWaiting);
  for (std::uint32_t place = kMostWaiting; place > 0; --place) {
    waiting_[place - 1].outgoing.reply.objects.reserve(msg::MAX_OBJECTS_PER_REQUEST);
    free_places_.push_back(place - 1);
  }
}

Reason StoreRequests::store_axes(const msg::Request& request, msg::Reply& reply) {
  if (saver_ == nullptr) return AbortCode::cannot_store_or_transfer;
  if (const auto reason = masters_.check_axes(request, false, reply); reason != msg::Reason::none) {
    return reason;
  }
  if (free_places_.empty() || saver_->room() < request.axes.size()) return msg::Reason::queue_full;
  for (const std::uint16_t number : request.axes) {
    order(axes_.index_of_checked(number), request.kind == msg::RequestKind::restore, kNoObject);
  }
  return msg::Reason::none;
}

Reason StoreRequests::store_by_write(std::size_t axis, ObjectRow row, std::int64_t value,
                                     std::size_t place) {
  if (const AbortCode code = axes_.write_signature(axis, row, value); code != AbortCode::none) {
    return code;
  }
  if (saver_ == nullptr) return AbortCode::cannot_store_or_transfer;
  if (free_places_.empty() || saver_->room() == 0) return AbortCode::out_of_memory;
  order(axis, row == "restore_all_default_parameters"_object, place);
  return msg::Reason::none;
}

/// Gives an order for the present request, which will take the next free place.
void StoreRequests::order(std::size_t axis, bool forget, std::size_t object) {
  StoreOrder* const place = saver_->free_order();
  ensure(place != nullptr && !free_places_.empty(), "the request was checked for room");
  StoreOrder& order = *place;
  order.request = free_places_.back();
  order.axis = static_cast<std::uint16_t>(axis);
  order.number = axes_.number_of(axis);
  order.object = static_cast<std::uint16_t>(object);
  order.forget = forget;
  axes_.bank().read_parameters(axis, std::span(order.values).first(kStoredRows.size()));
  saver_->push();
  ++ordered_;
}

void StoreRequests::wait(std::uint64_t session, Reason reason, OutgoingReply& outgoing) {
  ensure(!free_places_.empty(), "a request that has given orders has a place");
  Waiting& waiting = waiting_[free_places_.back()];
  free_places_.pop_back();
  std::swap(waiting.outgoing, outgoing);
  waiting.session = session;
  waiting.reason = reason;
  waiting.orders = ordered_;
}

bool StoreRequests::is_waiting(const msg::Request& request) const {
  return std::ranges::any_of(waiting_, [&](const Waiting& waiting) {
    const auto& reply = waiting.outgoing.reply;
    return waiting.orders > 0 && reply.client == request.client &&
           reply.request_id == request.request_id;
  });
}

bool StoreRequests::answer() {
  if (saver_ == nullptr) return false;
  std::size_t count = 0;
  while (count < kOrdersPerTick && answer_order()) ++count;
  return count > 0;
}

/// @return whether an order was done and there was room for its answer.
bool StoreRequests::answer_order() {
  const StoreOrder* const order = saver_->returned();
  // The last place is reserved for the step that is being carried out, if any.
  if (order == nullptr || queue_.size() + 1 >= queue_.capacity()) return false;
  const std::uint32_t place = order->request;
  ensure(place < waiting_.size() && waiting_[place].orders > 0, "an order comes back once");
  take_order(*order, waiting_[place]);
  saver_->pop();
  if (--waiting_[place].orders == 0) {
    finish(waiting_[place]);
    free_places_.push_back(place);
  }
  return true;
}

/// Gives the axis exactly the values that are durable, effective from its next power cycle on.
void StoreRequests::take_order(const StoreOrder& order, Waiting& waiting) {
  if (order.error == 0) {
    counters_.saves.add();
    axes_.forget_stored(order.axis);
    if (!order.forget) {
      axes_.set_stored(order.axis, std::span(order.values).first(kStoredRows.size()));
    }
    return;
  }
  counters_.save_failures.add();
  if (order.object == kNoObject) {
    waiting.reason = AbortCode::hardware_error;
    masters_.name_refused(order.number, waiting.outgoing.reply);
  } else {
    waiting.outgoing.reply.objects[order.object].abort_code =
        Reason(AbortCode::hardware_error).on_wire();
  }
  events_.report({.kind = msg::EventKind::parameters,
                  .axis = order.number,
                  .session = waiting.session,
                  .code = ParameterCode::kSaveFailed,
                  .detail = SystemError{order.error}});
}

void StoreRequests::finish(Waiting& waiting) {
  OutgoingReply* const slot = queue_.free_slot();
  ensure(slot != nullptr, "the queue was checked for room");
  OutgoingReply& outgoing = *slot;
  std::swap(waiting.outgoing, outgoing);
  if (outgoing.reply.objects.empty()) outgoing.reply.tick = clock_.tick();
  answers_.finish(waiting.session, waiting.reason, outgoing.reply);
  answers_.push();
}

}  // namespace vdrive::service

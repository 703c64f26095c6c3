// SPDX-License-Identifier: Apache-2.0
// Stored parameters: orders to the saver, and what becomes of them.
#include "bench_engine.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::service {
namespace {

constexpr std::size_t kNoObject = msg::MAX_OBJECTS_PER_REQUEST;

}  // namespace

void BenchEngine::store_with(ParameterSaver& saver) {
  saver_ = &saver;
  waiting_stores_.resize(kMostWaitingStores);
  free_places_.reserve(kMostWaitingStores);
  for (std::uint32_t place = kMostWaitingStores; place > 0; --place) {
    waiting_stores_[place - 1].outgoing.reply.objects().reserve(msg::MAX_OBJECTS_PER_REQUEST);
    free_places_.push_back(place - 1);
  }
}

std::uint32_t BenchEngine::store_axes(const msg::Request& request, msg::Reply& reply) {
  if (saver_ == nullptr) return wire_code(AbortCode::cannot_store_or_transfer);
  if (const auto reason = check_axes(request, false, reply); reason != msg::REASON_NONE) {
    return reason;
  }
  if (free_places_.empty() || saver_->room() < request.axes().size()) return msg::REASON_QUEUE_FULL;
  for (const std::uint16_t number : request.axes()) {
    order(*index_of(number), request.kind() == msg::REQUEST_RESTORE, kNoObject);
  }
  return msg::REASON_NONE;
}

/// 1010h and 1011h as objects: the bank judges the signature.
std::uint32_t BenchEngine::store_by_write(std::size_t axis, ObjectAddress address,
                                          std::int64_t value, std::size_t object) {
  if (const AbortCode code = bank_.write(axis, address, value); code != AbortCode::none) {
    return wire_code(code);
  }
  if (saver_ == nullptr) return wire_code(AbortCode::cannot_store_or_transfer);
  if (free_places_.empty() || saver_->room() == 0) return wire_code(AbortCode::out_of_memory);
  order(axis, address == kRestoreParameters, object);
  return msg::REASON_NONE;
}

/// For the request in hand, which has the next free place.
void BenchEngine::order(std::size_t axis, bool forget, std::size_t object) {
  StoreOrder& order = *saver_->free_order();
  order.request = free_places_.back();
  order.axis = static_cast<std::uint16_t>(axis);
  order.number = numbers_[axis];
  order.object = static_cast<std::uint16_t>(object);
  order.forget = forget;
  bank_.read_parameters(axis, order.values);
  saver_->push();
  ++ordered_;
}

void BenchEngine::wait_for_orders(std::uint64_t session, std::uint32_t reason,
                                  OutgoingReply& outgoing) {
  WaitingStore& waiting = waiting_stores_[free_places_.back()];
  free_places_.pop_back();
  std::swap(waiting.outgoing, outgoing);
  waiting.session = session;
  waiting.reason = reason;
  waiting.orders = ordered_;
}

bool BenchEngine::is_storing(const msg::Request& request) const {
  return std::ranges::any_of(waiting_stores_, [&](const auto& waiting) {
    const auto& reply = waiting.outgoing.reply;
    return waiting.orders > 0 && reply.client() == request.client() &&
           reply.request_id() == request.request_id();
  });
}

bool BenchEngine::answer_stores() {
  bool any = false;
  for (std::size_t count = 0; saver_ != nullptr && count < kOrdersPerTick; ++count) {
    const StoreOrder* const order = saver_->returned();
    // The last place is for the step that is being carried out, if there is one.
    if (order == nullptr || outbox_.replies.size() + 1 >= outbox_.replies.capacity()) break;
    OutgoingReply* const slot = outbox_.replies.free_slot();
    any = true;
    const std::uint32_t place = order->request;
    WaitingStore& waiting = waiting_stores_[place];
    take_order(*order, waiting);
    saver_->pop();
    if (--waiting.orders == 0) {
      std::swap(waiting.outgoing, *slot);
      if (slot->reply.objects().empty()) slot->reply.tick(tick_);
      finish_reply(waiting.session, waiting.reason, slot->reply);
      outbox_.replies.push();
      free_places_.push_back(place);
    }
  }
  return any;
}

void BenchEngine::take_order(const StoreOrder& order, WaitingStore& waiting) {
  if (order.error == 0) {
    counters_.saves.add();
    keep_in_bank(order);
    return;
  }
  counters_.save_failures.add();
  const std::uint32_t code = wire_code(AbortCode::hardware_error);
  if (order.object == kNoObject) {
    waiting.reason = code;
    refuse_axis(order.number, waiting.outgoing.reply);
  } else {
    waiting.outgoing.reply.objects()[order.object].abort_code(code);
  }
  report({.kind = msg::EVENT_PARAMETERS,
          .axis = order.number,
          .session = waiting.session,
          .code = ParameterNews::kSaveFailed,
          .detail = SystemError{order.error}});
}

/// From the next power cycle on the axis has what is durable, and not a value more.
void BenchEngine::keep_in_bank(const StoreOrder& order) {
  bank_.forget_stored(order.axis);
  to_journal({.kind = JournalChange::Kind::forgot, .axis = order.axis});
  for (std::size_t position = 0; position < kStoredCount && !order.forget; ++position) {
    const ObjectAddress address = describe(kStoredRows[position]).address;
    bank_.set_stored(order.axis, address, order.values[position]);
    to_journal({.kind = JournalChange::Kind::stored,
                .axis = order.axis,
                .address = address,
                .value = order.values[position]});
  }
}

}  // namespace vdrive::service

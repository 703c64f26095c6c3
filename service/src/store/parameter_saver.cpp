// SPDX-License-Identifier: Apache-2.0
#include "store/parameter_saver.hpp"

#include "base/log.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <cerrno>
#include <chrono>
#include <exception>
#include <system_error>
#include <utility>

namespace vdrive::service {
namespace {

// The saver polls, because the tick thread must not make a system call to wake it.
constexpr std::chrono::milliseconds kNap{2};

static_assert(kStoredCount <= kMostStored, "an order has room for each object that is stored");

void save(const StoreOrder& order, ParameterTable& table) {
  if (order.forget) {
    table.erase(order.number);
    return;
  }
  auto& values = table[order.number];
  values.clear();
  values.reserve(kStoredRows.size());
  for (std::size_t position = 0; position < kStoredRows.size(); ++position) {
    values.push_back({describe(kStoredRows[position]).address, order.values[position]});
  }
}

}  // namespace

ParameterSaver::ParameterSaver(std::unique_ptr<ParameterStore> store, ParameterTable table)
    : store_(std::move(store)),
      table_(std::move(table)),
      orders_(kMostOrders),
      returned_(kMostOrders) {
  batch_.reserve(kMostOrders);
}

ParameterSaver::~ParameterSaver() {
  close();
}

void ParameterSaver::start(std::function<void()> ready) {
  ready_ = std::move(ready);
  thread_ = std::thread([this] {
    run();
  });
}

void ParameterSaver::close() noexcept {
  if (thread_.joinable()) {
    stop_.store(true, std::memory_order_release);
    thread_.join();
  }
}

StoreOrder* ParameterSaver::free_order() noexcept {
  return room() == 0 ? nullptr : orders_.free_slot();
}

void ParameterSaver::push() noexcept {
  ++on_their_way_;
  orders_.push();
}

void ParameterSaver::pop() noexcept {
  ensure(on_their_way_ > 0, "an order comes back once");
  returned_.pop();
  --on_their_way_;
}

void ParameterSaver::run() noexcept {
  for (bool last = false; !last;) {
    last = stop_.load(std::memory_order_acquire);
    if (save_waiting()) {
      ready_();
    } else if (!last) {
      std::this_thread::sleep_for(kNap);
    }
  }
}

bool ParameterSaver::save_waiting() {
  batch_.clear();
  while (const StoreOrder* const order = orders_.front()) {
    batch_.push_back(*order);
    orders_.pop();
  }
  const int error = batch_.empty() ? 0 : save_batch();
  for (StoreOrder& order : batch_) {
    order.error = error;
    StoreOrder* const slot = returned_.free_slot();
    ensure(slot != nullptr, "the queue is as long as all orders that may be on their way");
    *slot = order;
    returned_.push();
  }
  return !batch_.empty();
}

/// @return the errno of a failure, or 0.
int ParameterSaver::save_batch() noexcept {
  try {
    ParameterTable next = table_;
    for (const StoreOrder& order : batch_) save(order, next);
    store_->save(next);
    table_ = std::move(next);
    return 0;
  } catch (const std::system_error& error) {
    log_error("parameters are not stored: {}", error.what());
    return error.code().value() == 0 ? EIO : error.code().value();
  } catch (const std::exception& error) {
    log_error("parameters are not stored: {}", error.what());
    return ENOMEM;
  }
}

}  // namespace vdrive::service

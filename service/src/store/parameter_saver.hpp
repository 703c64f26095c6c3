// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/ring.hpp"
#include "store/parameter_store.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

namespace vdrive::service {

/// Room for the stored values of an axis.
inline constexpr std::size_t kMostStored = 96;

/// An order to store or forget the values of one axis, and later its result.
struct StoreOrder {
  std::uint32_t request = 0;  ///< number of the request in the engine
  std::uint16_t axis = 0;     ///< index on the bench
  std::uint16_t number = 0;   ///< of the axis on the bench
  std::uint16_t object = 0;   ///< position of the object in a write request
  bool forget = false;
  std::array<std::int64_t, kMostStored> values{};  ///< of kStoredRows, in their order
  int error = 0;                                   ///< errno; 0 = durable
};

/// Saves parameters in a separate thread. The thread that steps the bank hands over orders without
/// lock, allocation or system call. A save includes all orders that wait when it begins; orders
/// that arrive during a save go into the next one. An order is returned when it is durable or has
/// failed; a failed save leaves the previous parameters in place.
class ParameterSaver {
 public:
  /// The maximum number of unfinished orders.
  static constexpr std::size_t kMostOrders = 2'048;

  /// @param table the present content of the store
  ParameterSaver(std::unique_ptr<ParameterStore> store, ParameterTable table);
  ~ParameterSaver();
  ParameterSaver(const ParameterSaver&) = delete;
  ParameterSaver& operator=(const ParameterSaver&) = delete;

  /// Starts the thread that saves. @param ready is called in that thread when orders are returned
  void start(std::function<void()> ready);

  /// Saves the waiting orders and ends the thread. Idempotent.
  void close() noexcept;

  /// Saves the waiting orders in the calling thread: for tests, which do not call `start`.
  /// @return whether there were any
  bool save_waiting();

  // The functions below are for the thread that steps the bank.

  /// @return an order to fill and push, or nullptr if too many are unfinished.
  [[nodiscard]] StoreOrder* free_order() noexcept;

  /// @return how many more orders may be pushed now.
  [[nodiscard]] std::size_t room() const noexcept { return kMostOrders - on_their_way_; }

  void push() noexcept;

  /// @return the oldest returned order, or nullptr.
  [[nodiscard]] const StoreOrder* returned() noexcept { return returned_.front(); }

  void pop() noexcept;

 private:
  void run() noexcept;
  [[nodiscard]] int save_batch() noexcept;

  std::unique_ptr<ParameterStore> store_;
  ParameterTable table_;  ///< the durable parameters
  std::vector<StoreOrder> batch_;
  Ring<StoreOrder> orders_;
  Ring<StoreOrder> returned_;
  std::size_t on_their_way_ = 0;
  std::function<void()> ready_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
};

}  // namespace vdrive::service

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

/// Room for the values that an axis stores.
inline constexpr std::size_t kMostStored = 96;

/// One axis to be stored or to be forgotten, and on the way back what became of it.
struct StoreOrder {
  std::uint32_t request = 0;  ///< as the engine counts them
  std::uint16_t axis = 0;     ///< index on the bench
  std::uint16_t number = 0;   ///< of the axis on the bench
  std::uint16_t object = 0;   ///< place of the object in a request that writes
  bool forget = false;
  std::array<std::int64_t, kMostStored> values{};  ///< of kStoredRows, from the first on
  int error = 0;                                   ///< errno; 0 = durable
};

/// Saves parameters away from the thread that steps the bank, which hands orders over without lock,
/// allocation or system call. All orders that wait when a save begins are in it: while one save
/// runs the next gathers. An order comes back when it is durable or has failed; a failed save
/// leaves what was stored before.
class ParameterSaver {
 public:
  /// The highest number of orders that are not finished.
  static constexpr std::size_t kMostOrders = 2'048;

  /// @param table what the store holds
  ParameterSaver(std::unique_ptr<ParameterStore> store, ParameterTable table);
  ~ParameterSaver();
  ParameterSaver(const ParameterSaver&) = delete;
  ParameterSaver& operator=(const ParameterSaver&) = delete;

  /// Starts the thread that saves. @param ready is called there when orders have come back.
  void start(std::function<void()> ready);

  /// Saves what waits and ends the thread. Idempotent.
  void close() noexcept;

  /// Saves what waits, in the calling thread: for tests, which do not `start`.
  /// @return whether there was anything.
  bool save_waiting();

  /// The thread that steps the bank, from here on.
  /// @return an order to be filled and pushed, or nullptr when too many are on their way.
  [[nodiscard]] StoreOrder* free_order() noexcept;

  /// @return how many more orders may be pushed now.
  [[nodiscard]] std::size_t room() const noexcept { return kMostOrders - on_their_way_; }

  void push() noexcept;

  /// @return the oldest order that has come back, or nullptr.
  [[nodiscard]] const StoreOrder* returned() noexcept { return returned_.front(); }

  void pop() noexcept;

 private:
  void run() noexcept;
  [[nodiscard]] int save_batch() noexcept;

  std::unique_ptr<ParameterStore> store_;
  ParameterTable table_;  ///< what is durable
  std::vector<StoreOrder> batch_;
  Ring<StoreOrder> orders_;
  Ring<StoreOrder> returned_;
  std::size_t on_their_way_ = 0;
  std::function<void()> ready_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
};

}  // namespace vdrive::service

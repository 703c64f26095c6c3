// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "simulation/happenings.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::simulation {

/// The registers that the actors write and that 1010h stores.
struct StoredValues {
  std::uint32_t stamp = 100;        ///< 6067h, with its default
  std::uint32_t velocity = 68'267;  ///< 6081h, with its default

  bool operator==(const StoredValues&) const = default;
};

/// By axis number.
using StoredSet = std::map<std::uint16_t, StoredValues>;

/// The required content of a disk, by the requests and by what happened to the disk. This model
/// outlasts the runs of the service.
class StoreModel {
 public:
  static constexpr std::size_t kNoObject = static_cast<std::size_t>(-1);

  struct Order {
    std::uint64_t request = 0;
    std::uint16_t axis = 0;
    std::size_t object = kNoObject;      ///< index in a request that writes
    std::optional<StoredValues> values;  ///< nullopt: to be deleted
    bool failed = false;
  };

  /// The result of a save.
  enum class Outcome : std::uint8_t {
    durable,
    refused,   ///< the new file never replaced the old one
    doubtful,  ///< the new file may have replaced the old one: the disk has either set
  };

  /// The service starts with this set.
  void start(const StoredSet& loaded, Happenings& happenings);

  void order(Order order) { waiting_.push_back(std::move(order)); }

  /// All waiting orders were in one save.
  void save(Outcome outcome);

  /// @return the oldest order of a finished save.
  [[nodiscard]] Order take_back();

  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

  [[nodiscard]] std::size_t saved() const { return saved_.size(); }

 private:
  static std::string words_of(const StoredSet& set);

  StoredSet durable_;
  std::vector<StoredSet> doubtful_;  ///< each may be on the disk instead
  StoredSet in_force_;               ///< in the service: the next save changes it
  std::deque<Order> waiting_;
  std::deque<Order> saved_;
};

}  // namespace vdrive::simulation

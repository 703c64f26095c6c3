// SPDX-License-Identifier: Apache-2.0
#include "simulation/store_model.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::simulation {

std::string StoreModel::words_of(const StoredSet& set) {
  std::string words = "stored of " + std::to_string(set.size()) + " axes:";
  for (const auto& [axis, values] : set) {
    words += ' ' + std::to_string(axis) + ": 6067h " + std::to_string(values.stamp) + " 6081h " +
             std::to_string(values.velocity);
  }
  return words;
}

void StoreModel::start(const StoredSet& loaded, Happenings& happenings) {
  if (loaded != durable_ && std::ranges::find(doubtful_, loaded) == doubtful_.end()) {
    happenings.fail(Invariant::kStored, 0,
                    words_of(durable_) + " or one of " + std::to_string(doubtful_.size()) +
                        " sets that were being stored",
                    words_of(loaded));
  }
  in_force_ = loaded;
  waiting_.clear();
  saved_.clear();
}

void StoreModel::save(Outcome outcome) {
  StoredSet next = in_force_;
  for (Order& order : waiting_) {
    if (order.values) {
      next[order.axis] = *order.values;
    } else {
      next.erase(order.axis);
    }
    order.failed = outcome != Outcome::durable;
    saved_.push_back(std::move(order));
  }
  waiting_.clear();
  if (outcome == Outcome::durable) {
    durable_ = in_force_ = std::move(next);
    doubtful_.clear();
  } else if (outcome == Outcome::doubtful) {
    doubtful_.push_back(std::move(next));
  }
}

StoreModel::Order StoreModel::take_back() {
  Order order = std::move(saved_.front());
  saved_.pop_front();
  return order;
}

}  // namespace vdrive::simulation

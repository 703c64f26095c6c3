// SPDX-License-Identifier: Apache-2.0
#include "worker.hpp"

#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <vector>

namespace vdrive::bridge {
namespace {

TEST(Worker, DoesOneJobAfterTheOther) {
  std::vector<int> done;
  std::promise<void> last;
  {
    Worker worker;
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(worker.post([&done, i] {
        done.push_back(i);
      }));
    }
    ASSERT_TRUE(worker.post([&last] {
      last.set_value();
    }));
    last.get_future().wait();
  }
  EXPECT_EQ(done, (std::vector{0, 1, 2, 3, 4}));
}

TEST(Worker, RefusesMoreJobsThanItHasRoomForAndAllAfterItsEnd) {
  std::promise<void> begun;
  std::promise<void> released;
  Worker worker;
  ASSERT_TRUE(worker.post([&] {
    begun.set_value();
    released.get_future().wait();
  }));
  begun.get_future().wait();
  for (std::size_t i = 0; i < Worker::kMostJobs; ++i) ASSERT_TRUE(worker.post([] {}));
  EXPECT_FALSE(worker.post([] {}));
  worker.close();
  EXPECT_FALSE(worker.post([] {}));
  released.set_value();
}

TEST(Worker, DropsTheJobsThatWaitAtItsEnd) {
  std::promise<void> begun;
  std::promise<void> released;
  bool is_done = false;
  auto worker = std::make_unique<Worker>();
  ASSERT_TRUE(worker->post([&] {
    begun.set_value();
    released.get_future().wait();
  }));
  begun.get_future().wait();
  ASSERT_TRUE(worker->post([&is_done] {
    is_done = true;
  }));
  worker->close();
  released.set_value();
  worker.reset();
  EXPECT_FALSE(is_done);
}

TEST(Worker, EndsWhatAJobHoldsWithTheJob) {
  auto held = std::make_shared<int>(1);
  const std::weak_ptr<int> seen = held;
  std::promise<void> next;
  Worker worker;
  ASSERT_TRUE(worker.post([held = std::move(held)] {}));
  ASSERT_TRUE(worker.post([&next] {
    next.set_value();
  }));
  next.get_future().wait();
  EXPECT_TRUE(seen.expired());
}

}  // namespace
}  // namespace vdrive::bridge

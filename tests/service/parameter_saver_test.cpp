// SPDX-License-Identifier: Apache-2.0
// Store orders from the stepping thread, and the saves that follow them.
#include "store/parameter_saver.hpp"

#include "service/failing_files.hpp"
#include "support/temporary_directory.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <future>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using service::ParameterSaver;
using service::ParameterStore;
using service::ParameterTable;
using service::StoreOrder;

constexpr std::uint32_t kBench = 7;
constexpr ObjectAddress kVelocity{0x6081, 0};

class Saver : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<ParameterStore> open() {
    return std::make_unique<ParameterStore>(directory.path(), kBench,
                                            std::make_unique<FailingFiles>(plan));
  }

  static void order(ParameterSaver& saver, std::uint16_t axis, std::int64_t value,
                    bool forget = false) {
    StoreOrder* const order = saver.free_order();
    ASSERT_NE(order, nullptr);
    order->number = axis;
    order->forget = forget;
    order->values.fill(value);
    saver.push();
  }

  /// Takes all finished orders. @return their error numbers.
  static std::vector<int> errors(ParameterSaver& saver) {
    std::vector<int> errors;
    while (const StoreOrder* const order = saver.returned()) {
      errors.push_back(order->error);
      saver.pop();
    }
    return errors;
  }

  TemporaryDirectory directory;
  FilePlan plan;
};

TEST_F(Saver, WritesAllWaitingAxesInOneSave) {
  {
    ParameterSaver saver(open(), {});
    EXPECT_FALSE(saver.save_waiting());
    order(saver, 1, 10);
    EXPECT_TRUE(saver.save_waiting());
    plan.set({});
    order(saver, 1, 11);
    EXPECT_TRUE(saver.save_waiting());
    const std::uint64_t of_one = plan.count;
    plan.set({});
    for (std::uint16_t axis = 1; axis <= 1'000; ++axis) order(saver, axis, axis);
    EXPECT_TRUE(saver.save_waiting());
    EXPECT_LE(plan.count, of_one + 16) << "a few more writes of a longer file, no save each";
    EXPECT_EQ(errors(saver), std::vector<int>(1'002, 0));
  }
  const ParameterTable table = open()->load().table;
  EXPECT_EQ(table.size(), 1'000U);
  EXPECT_EQ(table.at(1'000).size(), kStoredRows.size());
  EXPECT_EQ(table.at(1'000)[0].value, 1'000);
}

TEST_F(Saver, RemovesOneAxisAndKeepsAxesOutsideTheBench) {
  {
    ParameterSaver saver(open(), {{1, {{kVelocity, 1}}}, {900, {{kVelocity, 9}}}});
    order(saver, 1, 0, true);
    order(saver, 2, 20);
    saver.save_waiting();
  }
  const ParameterTable table = open()->load().table;
  EXPECT_EQ(table.count(1), 0U);
  EXPECT_EQ(table.count(2), 1U);
  EXPECT_EQ(table.at(900).at(0).value, 9);
}

TEST_F(Saver, ReportsAFailedAxisAndDoesNotStoreItLater) {
  {
    ParameterSaver saver(open(), {});
    plan.set([](std::uint64_t number) {
      if (number == 3) fail_with(ENOSPC);
    });
    order(saver, 1, 10);
    order(saver, 2, 20);
    saver.save_waiting();
    EXPECT_EQ(errors(saver), (std::vector{ENOSPC, ENOSPC}));
    plan.set({});
    order(saver, 2, 21);
    saver.save_waiting();
    EXPECT_EQ(errors(saver), std::vector{0});
  }
  const ParameterTable table = open()->load().table;
  EXPECT_EQ(table.count(1), 0U) << "refused";
  EXPECT_EQ(table.at(2).at(0).value, 21);
}

TEST_F(Saver, AcceptsABoundedNumberOfRequests) {
  ParameterSaver saver(open(), {});
  for (std::size_t count = 0; count < ParameterSaver::kMostOrders; ++count) {
    order(saver, 1, static_cast<std::int64_t>(count));
  }
  EXPECT_EQ(saver.room(), 0U);
  EXPECT_EQ(saver.free_order(), nullptr);
  saver.save_waiting();
  EXPECT_EQ(saver.free_order(), nullptr) << "they have not been taken back";
  EXPECT_EQ(errors(saver).size(), ParameterSaver::kMostOrders);
  EXPECT_NE(saver.free_order(), nullptr);
}

TEST_F(Saver, SavesInItsOwnThreadAndRingsTheDoorbell) {
  ParameterSaver saver(open(), {});
  std::promise<void> rung;
  saver.start([&rung] {
    rung.set_value();
  });
  order(saver, 1, 10);
  ASSERT_EQ(rung.get_future().wait_for(20s), std::future_status::ready);
  EXPECT_EQ(errors(saver), std::vector{0});
}

TEST_F(Saver, SavesWaitingAxesBeforeItEnds) {
  {
    ParameterSaver saver(open(), {});
    order(saver, 1, 10);
    saver.start([] {});
    saver.close();
    EXPECT_EQ(errors(saver), std::vector{0});
  }
  EXPECT_EQ(open()->load().table.size(), 1U);
}

}  // namespace
}  // namespace vdrive::test

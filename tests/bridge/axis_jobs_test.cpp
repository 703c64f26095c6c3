// SPDX-License-Identifier: Apache-2.0
#include "axis_jobs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::bridge {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr AxisJobs::Kind kConnection = 1;
constexpr AxisJobs::Kind kPowerCycle = 2;

/// Jobs that record their names when they run.
class RecordedJobs {
 public:
  bool add(AxisJobs::Kind kind, const std::string& name) {
    return jobs_.add(kind, [this, name] {
      done_.push_back(name);
    });
  }

  /// Runs all waiting jobs.
  /// @return their names
  std::vector<std::string> work() {
    while (!jobs_.is_empty()) jobs_.take()();
    return std::exchange(done_, {});
  }

 private:
  AxisJobs jobs_;
  std::vector<std::string> done_;
};

TEST(AxisJobs, AreCarriedOutInTheirOrder) {
  RecordedJobs jobs;
  EXPECT_TRUE(jobs.add(AxisJobs::kAccess, "read"));
  EXPECT_TRUE(jobs.add(kConnection, "lost"));
  EXPECT_TRUE(jobs.add(kPowerCycle, "cycle"));
  EXPECT_TRUE(jobs.add(kConnection, "back"));
  EXPECT_THAT(jobs.work(), ElementsAre("read", "lost", "cycle", "back"));
}

TEST(AxisJobs, RefuseAnAccessWhereTooManyWait) {
  RecordedJobs jobs;
  for (std::size_t i = 0; i < AxisJobs::kMost; ++i) {
    EXPECT_TRUE(jobs.add(AxisJobs::kAccess, "read"));
  }
  EXPECT_FALSE(jobs.add(AxisJobs::kAccess, "refused"));
  EXPECT_TRUE(jobs.add(kConnection, "lost")) << "it always reaches the drive";
  EXPECT_TRUE(jobs.add(kPowerCycle, "cycle"));
  const auto done = jobs.work();
  ASSERT_THAT(done, SizeIs(AxisJobs::kMost + 2));
  EXPECT_EQ(done[AxisJobs::kMost], "lost");
  EXPECT_EQ(done[AxisJobs::kMost + 1], "cycle");
}

TEST(AxisJobs, KeepWhatWasAskedForLastInAFlood) {
  RecordedJobs jobs;
  for (int i = 0; i < 10'000; ++i) {
    EXPECT_TRUE(jobs.add(kConnection, "lost"));
    EXPECT_TRUE(jobs.add(kPowerCycle, "cycle"));
    EXPECT_TRUE(jobs.add(kConnection, "back"));
  }
  EXPECT_TRUE(jobs.add(kConnection, "newest"));
  const auto done = jobs.work();
  EXPECT_THAT(done, SizeIs(testing::Le(AxisJobs::kMost + 2)));
  EXPECT_EQ(done.back(), "newest");
  EXPECT_THAT(done, testing::Contains("cycle"));
}

}  // namespace
}  // namespace vdrive::bridge

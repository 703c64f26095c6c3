// SPDX-License-Identifier: Apache-2.0
#include "bridge/drive_jobs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

/// Jobs that write down their names.
class RecordedJobs {
 public:
  bool add(DriveJobs::Kind kind, const std::string& name) {
    return jobs_.add(kind, [this, name] {
      done_.push_back(name);
    });
  }

  /// Carries out all that wait. @return their names
  std::vector<std::string> work() {
    while (!jobs_.is_empty()) jobs_.take()();
    return std::exchange(done_, {});
  }

 private:
  DriveJobs jobs_;
  std::vector<std::string> done_;
};

TEST(DriveJobs, AreCarriedOutInTheirOrder) {
  RecordedJobs jobs;
  EXPECT_TRUE(jobs.add(DriveJobs::Kind::access, "read"));
  EXPECT_TRUE(jobs.add(DriveJobs::Kind::connection, "lost"));
  EXPECT_TRUE(jobs.add(DriveJobs::Kind::power_cycle, "cycle"));
  EXPECT_TRUE(jobs.add(DriveJobs::Kind::connection, "back"));
  EXPECT_THAT(jobs.work(), ElementsAre("read", "lost", "cycle", "back"));
}

TEST(DriveJobs, RefuseAnAccessWhereTooManyWait) {
  RecordedJobs jobs;
  for (std::size_t i = 0; i < DriveJobs::kMost; ++i) {
    EXPECT_TRUE(jobs.add(DriveJobs::Kind::access, "read"));
  }
  EXPECT_FALSE(jobs.add(DriveJobs::Kind::access, "refused"));
  EXPECT_TRUE(jobs.add(DriveJobs::Kind::connection, "lost")) << "it always reaches the drive";
  EXPECT_TRUE(jobs.add(DriveJobs::Kind::power_cycle, "cycle"));
  const auto done = jobs.work();
  ASSERT_THAT(done, SizeIs(DriveJobs::kMost + 2));
  EXPECT_EQ(done[DriveJobs::kMost], "lost");
  EXPECT_EQ(done[DriveJobs::kMost + 1], "cycle");
}

TEST(DriveJobs, KeepWhatWasAskedForLastInAFlood) {
  RecordedJobs jobs;
  for (int i = 0; i < 10'000; ++i) {
    EXPECT_TRUE(jobs.add(DriveJobs::Kind::connection, "lost"));
    EXPECT_TRUE(jobs.add(DriveJobs::Kind::power_cycle, "cycle"));
    EXPECT_TRUE(jobs.add(DriveJobs::Kind::connection, "back"));
  }
  EXPECT_TRUE(jobs.add(DriveJobs::Kind::connection, "newest"));
  const auto done = jobs.work();
  EXPECT_THAT(done, SizeIs(testing::Le(DriveJobs::kMost + 2)));
  EXPECT_EQ(done.back(), "newest");
  EXPECT_THAT(done, testing::Contains("cycle"));
}

}  // namespace
}  // namespace vdrive::canopen

// SPDX-License-Identifier: Apache-2.0
#include "run/standstill.hpp"

#include <gtest/gtest.h>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using service::Counter;
using service::Standstill;

class StandstillTest : public testing::Test {
 protected:
  Counter ticks_;
  Counter status_;
  Standstill::Clock::time_point begin_;
  Standstill sut_{{{"ticks", &ticks_}, {"status", &status_}}, begin_};
};

TEST_F(StandstillTest, CountsFromTheStart) {
  EXPECT_EQ(sut_.look(begin_ + 3s).time, 3s);
}

TEST_F(StandstillTest, CountsFromTheLastLookThatFoundProgress) {
  ticks_.add();
  status_.add();
  EXPECT_EQ(sut_.look(begin_ + 3s).time, 0s);
  EXPECT_EQ(sut_.look(begin_ + 5s).time, 2s);
  ticks_.add();
  status_.add();
  EXPECT_EQ(sut_.look(begin_ + 6s).time, 0s);
}

TEST_F(StandstillTest, NamesTheThreadThatStandsLongest) {
  ticks_.add();
  EXPECT_EQ(sut_.look(begin_ + 3s).name, "status");
  status_.add();
  EXPECT_EQ(sut_.look(begin_ + 4s).name, "ticks");
}

// There may be two callers at the same time, such as a kubelet and a person.
TEST_F(StandstillTest, FindsProgressHoweverOftenOneLooks) {
  for (auto time = 1ms; time <= 10s; time += 1ms) {
    if (time % 10ms == 0ms) ticks_.add();
    if (time % 10ms == 5ms) status_.add();
    ASSERT_LE(sut_.look(begin_ + time).time, 10ms);
  }
}

}  // namespace
}  // namespace vdrive::test

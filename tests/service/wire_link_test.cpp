// SPDX-License-Identifier: Apache-2.0
#include "seam/wire_link.hpp"

#include "seam/byte_ring.hpp"
#include "seam/doorbell.hpp"
#include "seam/wire_region.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

class LaneOfALink : public testing::TestWithParam<Lane> {
 protected:
  [[nodiscard]] bool is_rung() { return bell_.wait_for(0ns); }

  const WireRegion region_{WireSettings{}, WireRegion::Sharing::none};
  WireLink sut_{region_};

 private:
  Doorbell bell_{GetParam() == Lane::status ? sut_.control().status_bell
                                            : sut_.control().reports_bell};
};

// The engine flushes a lane whether or not it has written to it.
TEST_P(LaneOfALink, WakesItsWireForWhatWaitsAndForNothingElse) {
  sut_.flush(GetParam());
  EXPECT_FALSE(is_rung()) << "it is empty";

  ASSERT_TRUE(sut_.ring(GetParam()).reserve(8).has_value());
  sut_.ring(GetParam()).commit({.size = 8, .full_size = 8, .party = {}});
  for (int flush = 0; flush < 2; ++flush) {
    sut_.flush(GetParam());
    EXPECT_TRUE(is_rung()) << "the record waits";
  }

  ByteRing received = region_.ring(GetParam());
  ASSERT_TRUE(received.front().has_value());
  received.pop();
  sut_.flush(GetParam());
  EXPECT_FALSE(is_rung()) << "the wire has it";
}

INSTANTIATE_TEST_SUITE_P(Lanes, LaneOfALink,
                         testing::Values(Lane::status, Lane::replies, Lane::reports),
                         [](const testing::TestParamInfo<Lane>& lane) -> std::string {
                           return lane.param == Lane::status    ? "status"
                                  : lane.param == Lane::replies ? "replies"
                                                                : "reports";
                         });

}  // namespace
}  // namespace vdrive::service

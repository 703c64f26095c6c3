// SPDX-License-Identifier: Apache-2.0
#include "guard/receive_coalescing.hpp"

#include <gtest/gtest.h>

namespace vdrive::wire {
namespace {

using namespace std::chrono_literals;
using std::chrono::microseconds;

/// A channel that receives a datagram of `size` bytes every `period`. Processing takes no time.
struct AChannel : testing::Test {
  ReceiveCoalescing sut{8ms};
  std::size_t size = 8'000;
  microseconds period = 1ms;
  ReceiveCoalescing::Clock::time_point now{1h};
  ReceiveCoalescing::Clock::time_point next = now;  ///< arrival of the next datagram

  /// Receives until the channel pauses. @return the pause
  microseconds until_pause() {
    while (true) {
      now = std::max(now, next);
      next += period;
      const microseconds pause = sut.pause_after(size, now);
      now += pause;
      sut.resumed(now);
      if (pause > 0us) return pause;
    }
  }

  /// @return the bytes that have arrived and were not received.
  std::size_t waiting() const {
    return now < next ? 0 : static_cast<std::size_t>((now - next) / period + 1) * size;
  }
};

// 8 datagrams of 8,000 bytes arrive in 8 ms: less than the limit of 65,536.
TEST_F(AChannel, PausesForTheLongestTimeAfterADatagramForWhichItWaited) {
  EXPECT_EQ(until_pause(), 8ms);
  EXPECT_EQ(waiting(), 64'000U);
  EXPECT_EQ(until_pause(), 8'000us * 65'536 / 72'000) << "the 8 that waited, and the next one";
}

TEST_F(AChannel, ProcessesWhatWaitsWithoutAPause) {
  static_cast<void>(until_pause());
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(sut.pause_after(size, now), 0us);
    sut.resumed(now);
  }
}

// 64 MB/s: a pause of 8 ms would let half a megabyte wait.
TEST_F(AChannel, PausesLessWhenMuchArrives) {
  size = 64'000;
  static_cast<void>(until_pause());
  for (int i = 0; i < 20; ++i) {
    static_cast<void>(until_pause());
    EXPECT_LE(waiting(), ReceiveCoalescing::kMostOfPause + size);
  }
}

TEST_F(AChannel, PausesForTheLongestTimeAgainWhenLittleArrives) {
  size = 64'000;
  for (int i = 0; i < 20; ++i) static_cast<void>(until_pause());
  size = 100;
  static_cast<void>(until_pause());  // counts the large ones that waited
  static_cast<void>(until_pause());
  EXPECT_EQ(until_pause(), 8ms);
}

TEST_F(AChannel, NeverPausesByDefault) {
  ReceiveCoalescing immediate(0us);
  EXPECT_EQ(immediate.pause_after(size, now), 0us);
}

}  // namespace
}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#include "bus/socket_can.hpp"

#include "bus/asio.hpp"
#include "canopen/recorded_port.hpp"
#include "support/random_cases.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <linux/can.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

TEST(CanFrame, HasIdentifierLengthAndBytes) {
  const can_frame frame = to_can_frame(data_frame(0x601, {0x40, 0x41, 0x60}));
  EXPECT_EQ(frame.can_id, 0x601U);
  EXPECT_EQ(frame.can_dlc, 3);
  EXPECT_EQ(frame.data[0], 0x40);
  EXPECT_EQ(frame.data[1], 0x41);
  EXPECT_EQ(frame.data[2], 0x60);
}

TEST(CanFrame, MarksTheExtendedFormatInTheHighestBit) {
  Frame frame = data_frame(0x1FFFFFFF, {});
  frame.is_extended = true;
  EXPECT_EQ(to_can_frame(frame).can_id, 0x9FFFFFFFU);
  // In the base format, the same number is a different identifier.
  frame.id = 0x81;
  EXPECT_EQ(to_can_frame(frame).can_id, 0x80000081U);
  EXPECT_EQ(from_can_frame(to_can_frame(frame)), frame);
}

TEST(CanFrame, MarksARemoteFrameAndKeepsItsLength) {
  const Frame frame{.id = 0x701, .is_remote = true, .size = 1};
  const can_frame converted = to_can_frame(frame);
  EXPECT_EQ(converted.can_id, 0x40000701U);
  EXPECT_EQ(converted.can_dlc, 1);
  EXPECT_EQ(from_can_frame(converted), frame);
}

TEST(CanFrame, HasNoBytesOfARemoteFrame) {
  can_frame frame{};
  frame.can_id = 0x701U | CAN_RTR_FLAG;
  frame.can_dlc = 8;
  std::fill(std::begin(frame.data), std::end(frame.data), __u8{0xFF});
  EXPECT_EQ(from_can_frame(frame), (Frame{.id = 0x701, .is_remote = true, .size = 8}));
}

TEST(CanFrame, IgnoresErrorMessagesOfTheController) {
  can_frame frame{};
  frame.can_id = CAN_ERR_FLAG | 0x40U;  // bus-off
  frame.can_dlc = 8;
  EXPECT_EQ(from_can_frame(frame), std::nullopt);
}

TEST(CanFrame, IgnoresMoreThan8Bytes) {
  can_frame frame{};
  frame.can_id = 0x123;
  frame.can_dlc = 9;
  EXPECT_EQ(from_can_frame(frame), std::nullopt);
}

TEST(CanFrame, ComesBackAsItWas) {
  test::Random random(11898);
  const std::uint64_t cases = test::case_count(2'000, 100'000);
  for (std::uint64_t i = 0; i < cases; ++i) {
    Frame frame;
    frame.is_extended = random.one_in(2);
    frame.is_remote = random.one_in(3);
    const std::uint32_t highest = frame.is_extended ? kHighestExtendedId : kHighestBaseId;
    frame.id = random.word() & highest;
    frame.size = static_cast<std::uint8_t>(random.below(kMostData + 1));
    for (std::size_t byte = 0; byte < frame.bytes().size(); ++byte) {
      frame.data.at(byte) = static_cast<std::uint8_t>(random.below(256));
    }
    ASSERT_EQ(from_can_frame(to_can_frame(frame)), frame);
  }
}

TEST(SocketCan, NamesAnInterfaceThatItCannotOpenAndTheRemedy) {
  // The reason depends on the kernel: either it has no CAN support, or there is no such interface.
  asio::io_context context;
  Bus bus;
  RecordedHost host;
  for (const char* const name : {"no-such-can", "", "a-name-of-more-than-15"}) {
    try {
      const SocketCan opened(context, bus, host, {.interface = name});
      FAIL() << "it is open: " << name;
    } catch (const std::runtime_error& error) {
      const std::string message = error.what();
      EXPECT_TRUE(message.starts_with("cannot open CAN interface '" + std::string(name) + "': "))
          << message;
      EXPECT_NE(message.find("--socketcand"), std::string::npos) << message;
    }
  }
}

TEST(SocketCan, RefusesAnInterfaceThatIsNoCan) {
  asio::io_context context;
  Bus bus;
  RecordedHost host;
  EXPECT_THROW(SocketCan(context, bus, host, {.interface = "lo"}), std::runtime_error);
}

/// A port on a socket pair instead of an interface; the test chooses the errors.
class PluggedInterface final : CanSockets {
  Bus bus_{};  // first: the other members are attached to it

 public:
  PluggedInterface() = default;

  ~PluggedInterface() override { unplug(); }

  PluggedInterface(const PluggedInterface&) = delete;
  PluggedInterface& operator=(const PluggedInterface&) = delete;

  void unplug() {
    if (wire_ >= 0) ::close(std::exchange(wire_, -1));
  }

  /// @return the frame sent to the interface; std::nullopt if there is none.
  [[nodiscard]] std::optional<Frame> sent() const {
    can_frame frame{};
    const ssize_t size = ::read(wire_, &frame, sizeof frame);
    return size == static_cast<ssize_t>(sizeof frame) ? from_can_frame(frame) : std::nullopt;
  }

  void receive(const Frame& frame) const {
    const can_frame converted = to_can_frame(frame);
    ASSERT_EQ(::write(wire_, &converted, sizeof converted), static_cast<ssize_t>(sizeof converted));
  }

  void run_until(const std::function<bool()>& is_done) {
    while (!is_done()) ASSERT_GT(context_.run_one_for(std::chrono::seconds(10)), 0U);
  }

  static constexpr std::uint8_t kMostWaiting = 8;

  /// Sends one frame more than can wait.
  void fill() {
    for (std::uint8_t frame = 0; frame <= kMostWaiting; ++frame) {
      master.send(data_frame(0x201, {frame}));
    }
  }

  [[nodiscard]] const Bus& bus() const { return bus_; }

  int write_error = 0;  ///< of each write; 0 = none
  int write_attempts = 0;
  int read_error = 0;  ///< of the next read
  int open_failures = 0;
  RecordedHost host{};
  std::vector<std::string>& lines = host.reports;
  RecordedPort master{bus_};

  [[nodiscard]] const SocketCanCounters& counters() const { return port_.counters(); }

 private:
  int open(const std::string& /*interface*/) override {
    if (open_failures > 0) {
      --open_failures;
      throw std::runtime_error("there is no network interface of this name");
    }
    unplug();
    std::array<int, 2> pair{};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, pair.data()) != 0) {
      throw std::runtime_error("no pair of sockets");
    }
    wire_ = pair[1];
    return pair[0];
  }

  [[nodiscard]] static ssize_t failed(int error) {
    errno = error;
    return -1;
  }

  ssize_t read(int socket, can_frame& frame) override {
    if (read_error != 0) return failed(std::exchange(read_error, 0));
    return ::read(socket, &frame, sizeof frame);
  }

  ssize_t write(int socket, const can_frame& frame) override {
    ++write_attempts;
    if (write_error != 0) return failed(write_error);
    return ::write(socket, &frame, sizeof frame);
  }

  int wire_ = -1;
  asio::io_context context_;
  SocketCan port_{context_,
                  bus_,
                  host,
                  {.interface = "can7",
                   .most_waiting_frames = kMostWaiting,
                   .holds_bus = true,
                   .reopen_period = std::chrono::milliseconds(1)},
                  *this};
};

TEST(SocketCan, DropsFramesWhileTheInterfaceIsDownAndSendsThoseAfterIt) {
  PluggedInterface can;
  can.write_error = ENOBUFS;  // the interface's queue is full: frames wait
  can.master.send(data_frame(0x201, {1}));
  can.master.send(data_frame(0x201, {2}));
  EXPECT_EQ(can.counters().dropped_frames, 0U);
  can.write_error = ENETDOWN;
  can.run_until([&can] {
    return !can.lines.empty();
  });
  EXPECT_EQ(can.counters().dropped_frames, 2U);
  can.master.send(data_frame(0x201, {3}));
  EXPECT_EQ(can.counters().dropped_frames, 3U);
  can.write_error = 0;
  can.master.send(data_frame(0x201, {4}));
  EXPECT_EQ(can.sent(), data_frame(0x201, {4}));
  EXPECT_EQ(can.sent(), std::nullopt);
  EXPECT_THAT(can.lines,
              testing::ElementsAre(testing::StartsWith("is down: frames are dropped"), "is up"));
}

TEST(SocketCan, HoldsTheBusWhileTheQueueOfTheInterfaceIsFull) {
  PluggedInterface can;
  can.write_error = ENOBUFS;
  for (std::uint8_t frame = 0; frame <= PluggedInterface::kMostWaiting; ++frame) {
    EXPECT_FALSE(can.bus().is_held());
    can.master.send(data_frame(0x201, {frame}));
  }
  EXPECT_TRUE(can.bus().is_held());
  can.receive(data_frame(0x080, {}));
  can.run_until([&can] {
    return can.write_attempts > 10;
  });
  EXPECT_TRUE(can.master.frames.empty()) << "it reads none";
  can.write_error = 0;
  can.run_until([&can] {
    return !can.master.frames.empty();
  });
  EXPECT_FALSE(can.bus().is_held());
  for (std::uint8_t frame = 0; frame <= PluggedInterface::kMostWaiting; ++frame) {
    EXPECT_EQ(can.sent(), data_frame(0x201, {frame}));
  }
  EXPECT_EQ(can.counters().dropped_frames, 0U);
}

TEST(SocketCan, HoldsNoBusWhenItsInterfaceGoesDown) {
  PluggedInterface can;
  can.write_error = ENOBUFS;
  can.fill();
  ASSERT_TRUE(can.bus().is_held());
  can.write_error = ENETDOWN;
  can.run_until([&can] {
    return !can.lines.empty();
  });
  EXPECT_FALSE(can.bus().is_held());
}

TEST(SocketCan, ReportsAnInterfaceThatHoldsTheBusForASecond) {
  PluggedInterface can;
  can.write_error = ENOBUFS;
  can.fill();
  can.run_until([&can] {
    return !can.lines.empty();
  });
  EXPECT_THAT(can.lines, testing::ElementsAre(testing::StartsWith(
                             "is not sending: 9 frames are queued for it; bus and drive")));
}

TEST(SocketCan, HoldsNoBusForFramesThatTheInterfaceHasRefused) {
  PluggedInterface can;
  can.write_error = ENOBUFS;
  can.fill();
  ASSERT_TRUE(can.bus().is_held());
  can.write_error = EINVAL;
  can.run_until([&can] {
    return can.counters().dropped_frames == 5;
  });
  EXPECT_FALSE(can.bus().is_held()) << "four are left, half of those that may wait";
}

TEST(SocketCan, IsUpAgainWithTheFirstFrameThatItReceives) {
  PluggedInterface can;
  can.read_error = ENETDOWN;
  can.receive(data_frame(0x181, {1}));  // wakes the reader
  can.run_until([&can] {
    return !can.master.frames.empty();
  });
  EXPECT_THAT(can.lines, testing::ElementsAre(testing::StartsWith("is down"), "is up"));
}

TEST(SocketCan, OpensAnInterfaceAgainThatWasUnplugged) {
  for (const int error : {ENODEV, ENXIO}) {
    PluggedInterface can;
    can.open_failures = 2;
    can.write_error = error;
    can.master.send(data_frame(0x201, {1}));
    ASSERT_THAT(can.lines,
                testing::ElementsAre(testing::StartsWith("is gone: frames are dropped")));
    can.write_error = 0;
    can.master.send(data_frame(0x201, {2}));
    EXPECT_EQ(can.counters().dropped_frames, 2U);
    can.run_until([&can] {
      return can.lines.size() == 2;
    });
    EXPECT_EQ(can.lines[1], "is open again");
    EXPECT_EQ(can.open_failures, 0);
    can.master.send(data_frame(0x201, {3}));
    EXPECT_EQ(can.sent(), data_frame(0x201, {3}));
    can.receive(data_frame(0x181, {1}));
    can.run_until([&can] {
      return !can.master.frames.empty();
    });
  }
}

TEST(SocketCan, NoticesByReadingThatTheInterfaceIsGone) {
  PluggedInterface can;
  can.read_error = ENODEV;
  can.receive(data_frame(0x181, {1}));  // wakes the reader
  can.run_until([&can] {
    return can.lines.size() == 2;
  });
  EXPECT_EQ(can.lines[1], "is open again");
}

}  // namespace
}  // namespace vdrive::canopen

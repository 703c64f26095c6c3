// SPDX-License-Identifier: Apache-2.0
#include "bus/socket_can.hpp"

#include "bus/asio.hpp"
#include "canopen/recorded_port.hpp"
#include "core/support/random_cases.hpp"

#include <gtest/gtest.h>

#include <linux/can.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>

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
  // The same number in the base format is another identifier.
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
  frame.can_id = CAN_ERR_FLAG | 0x40U;  // bus off
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
  // Where the kernel has no CAN this is the reason, else that there is no such interface.
  asio::io_context context;
  Bus bus;
  for (const char* const name : {"no-such-can", "", "a-name-of-more-than-15"}) {
    try {
      const SocketCan opened(context, bus, {.interface = name});
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
  EXPECT_THROW(SocketCan(context, bus, {.interface = "lo"}), std::runtime_error);
}

}  // namespace
}  // namespace vdrive::canopen

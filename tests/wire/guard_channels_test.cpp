// SPDX-License-Identifier: Apache-2.0
// The order in which a guard passes on datagrams of several channels, without a network.
#include "guard/guard.hpp"
#include "wire/datagrams.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <future>
#include <utility>

namespace vdrive::wire {
namespace {

using namespace std::chrono_literals;
using test::Body;
using test::Datagram;
using test::DatagramWriter;

constexpr auto kLongest = 40s;
constexpr auto kNothingHappens = 300ms;

constexpr test::GuidPrefix kAnnouncer{1, 15, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
constexpr std::uint8_t kLittleEndian = 1;
constexpr std::uint8_t kLittleEndianWithData = 5;

Datagram of_the_participant() {
  return DatagramWriter(kAnnouncer)
      .add(0x15, kLittleEndianWithData, test::announcement(kAnnouncer, "vdrived 1", 600).bytes())
      .bytes();
}

/// A heartbeat of the writer that announces the sender's writers. The library reads it only if it
/// knows the sender.
Datagram of_its_writers() {
  Body body;
  body.entity(test::kPublicationsReader).entity(test::kPublicationsWriter);
  return DatagramWriter(kAnnouncer)
      .add(0x07, kLittleEndian, body.sequence(1).sequence(2).u32(1).bytes())
      .bytes();
}

/// A channel whose receiver plays the library.
class Channel final : public Guard::Receiver {
 public:
  Channel(Guard& guard, std::uint32_t port) : guard_(guard) {
    locator_.port = port;
    guard_.open(locator_, this);
  }

  /// Receives a datagram on this channel, in a separate thread.
  /// @return ready when the guard has handled it.
  [[nodiscard]] std::future<void> arrive(Datagram datagram) {
    return std::async(std::launch::async, [this, datagram = std::move(datagram)] {
      guard_.receive(*this, datagram, locator_, locator_);
    });
  }

  void close() { guard_.close(locator_); }

  /// @return ready when the library has started to read a datagram.
  [[nodiscard]] std::future<void> read() { return read_.get_future(); }

  std::function<void()> while_reading = [] {};

 private:
  void OnDataReceived(const std::uint8_t* /*data*/, std::uint32_t /*size*/,
                      const Guard::Locator& /*local*/, const Guard::Locator& /*remote*/) override {
    read_.set_value();
    while_reading();
  }

  Guard& guard_;
  Guard::Locator locator_;
  std::promise<void> read_;
};

TEST(ReceivedDatagram, WaitsUntilTheLibraryReads) {
  Guard guard({});
  Channel channel(guard, 1);
  auto read = channel.read();
  auto done = channel.arrive(of_the_participant());
  EXPECT_EQ(read.wait_for(kNothingHappens), std::future_status::timeout);
  guard.begin();
  EXPECT_EQ(read.wait_for(kLongest), std::future_status::ready);
  done.get();
  EXPECT_EQ(guard.counts().handed_over, 1U);
}

/// When a participant cannot be created, it closes its channels and joins the receiving threads.
TEST(ReceivedDatagram, DoesNotBlockAChannelThatClosesBeforeTheLibraryReads) {
  Guard guard({});
  Channel channel(guard, 1);
  const auto done = channel.arrive(of_its_writers());
  channel.close();
  EXPECT_EQ(done.wait_for(kLongest), std::future_status::ready);
}

TEST(AnnouncementByASecondChannel, WaitsUntilTheLibraryHasReadTheFirst) {
  Guard guard({});
  guard.begin();
  Channel multicast(guard, 1);
  Channel unicast(guard, 2);
  auto second = unicast.read();
  std::future<void> second_done;
  multicast.while_reading = [&] {
    second_done = unicast.arrive(of_the_participant());
    EXPECT_EQ(second.wait_for(kNothingHappens), std::future_status::timeout);
  };
  multicast.arrive(of_the_participant()).get();
  second_done.get();
  EXPECT_EQ(second.wait_for(0s), std::future_status::ready);
}

TEST(OtherDatagram, DoesNotWaitForAnAnnouncementOnAnotherChannel) {
  Guard guard({});
  guard.begin();
  Channel multicast(guard, 1);
  Channel unicast(guard, 2);
  auto second = unicast.read();
  multicast.while_reading = [&] {
    auto second_done = unicast.arrive(of_its_writers());
    EXPECT_EQ(second.wait_for(kLongest), std::future_status::ready);
    second_done.get();
  };
  multicast.arrive(of_the_participant()).get();
}

}  // namespace
}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
// Programs that flood the service: its memory stays bounded, and it still serves other clients.
#include "service/probe.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/library_log.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive_messages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <csignal>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <sstream>
#include <string>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;

/// The queues keep the memory of their largest messages: 1,024 arrivals and 1,024 waiting frames of
/// at most 256 axes with some 300 bytes each are 160 MB; the readers' histories of 1,024 samples of
/// at most 75 kB are as much again.
constexpr std::size_t kMostMemory = std::size_t{512} * 1024;  // [kB]
/// The most that a second flood of the same kind may add.
constexpr std::size_t kLeeway = std::size_t{16} * 1024;  // [kB]

/// A program that only sends and never reads.
class Flooder {
 public:
  Flooder()
      : participant_(wire::make_participant({.domain = test_domain()}, "flooder")),
        requests_(*participant_),
        frames_(*participant_) {}

  [[nodiscard]] bool is_received(std::chrono::milliseconds within = 30s) {
    return requests_.wait_for_matched(1, within) && frames_.wait_for_matched(1, within);
  }

  // A write may fail after it has waited for room in the service.
  void send(const msg::Request& request) { static_cast<void>(requests_.write(request)); }

  void send(const msg::CommandFrame& frame) { static_cast<void>(frames_.write(frame)); }

  [[nodiscard]] std::uint64_t random() { return random_(); }

  [[nodiscard]] wire::Source source() const { return participant_->source(); }

  [[nodiscard]] msg::Request request(msg::RequestKind kind) {
    msg::Request request;
    request.kind = kind;
    request.client = random() | 1U;
    request.session = random() | 1U;
    request.request_id = random();
    request.bench = 1;
    return request;
  }

  [[nodiscard]] msg::CommandFrame frame() {
    msg::CommandFrame frame;
    frame.bench = 1;
    frame.session = random() | 1U;
    frame.sequence_number = random();
    frame.flags = msg::FRAME_WANT_REPLY;
    return frame;
  }

 private:
  std::unique_ptr<wire::Participant> participant_;
  wire::Publication<msg::Request> requests_;
  wire::Publication<msg::CommandFrame> frames_;
  std::mt19937_64 random_{1};
};

msg::ObjectAccess statusword() {
  msg::ObjectAccess access;
  access.axis = 1;
  access.index = 0x6041;
  return access;
}

void fill(msg::CommandFrame& frame, std::size_t axes, std::size_t objects) {
  msg::ObjectValue value;
  value.index = 0x6081;
  value.value = 1;
  msg::AxisCommand command;
  command.objects.assign(objects, value);
  for (std::size_t axis = 1; axis <= axes; ++axis) {
    command.axis = static_cast<std::uint16_t>(axis);
    frame.axes.push_back(command);
  }
}

struct Flood {
  const char* name;
  const char* clock;
  std::function<void(Flooder&, Probe&)> send;
};

std::vector<Flood> floods() {
  return {
      {"SessionsThatAcquire", "realtime",
       [](Flooder& flooder, Probe&) {
         for (int count = 0; count < 3'000; ++count) {
           auto request = flooder.request(msg::RequestKind::take_over);
           request.axes.push_back(1);
           flooder.send(request);
         }
       }},
      {"RequestsWhoseAnswersNobodyReads", "realtime",
       [](Flooder& flooder, Probe&) {
         auto request = flooder.request(msg::RequestKind::read);
         request.objects.assign(msg::MAX_OBJECTS_PER_REQUEST, statusword());
         for (int count = 0; count < 3'000; ++count) flooder.send(request);
       }},
      {"LargestFramesOfUnknownSessions", "realtime",
       [](Flooder& flooder, Probe&) {
         auto frame = flooder.frame();
         fill(frame, msg::MAX_AXES_PER_FRAME, msg::MAX_OBJECTS_PER_AXIS);
         for (int count = 0; count < 1'500; ++count) {
           frame.session = flooder.random() | 1U;
           flooder.send(frame);
         }
       }},
      {"FramesForLaterTicks", "lockstep",
       [](Flooder&, Probe& probe) {
         ASSERT_TRUE(probe.acquire({1}));
         for (int count = 0; count < 1'500; ++count) {
           auto frame = probe.make_frame();
           fill(frame, 1, msg::MAX_OBJECTS_PER_AXIS);
           frame.apply_at_tick = 9'000;
           frame.valid_until_tick = 9'000;
           probe.send(frame);
         }
       }},
      {"MessagesBeyondEveryBound", "realtime",
       [](Flooder& flooder, Probe&) {
         auto request = flooder.request(msg::RequestKind::read);
         request.objects.assign(20'000, statusword());
         auto frame = flooder.frame();
         fill(frame, 2'000, 20);
         for (int count = 0; count < 20; ++count) {
           flooder.send(request);
           flooder.send(frame);
         }
       }},
      {"SteppersOfALockStepBench", "lockstep",
       [](Flooder& flooder, Probe&) {
         for (int count = 0; count < 2'000; ++count) {
           flooder.send(flooder.request(msg::RequestKind::join_clock));
           flooder.send(flooder.request(msg::RequestKind::leave_clock));
         }
       }},
      {"StepsThatWaitForEver", "lockstep",
       [](Flooder& flooder, Probe&) {
         for (int count = 0; count < 2'000; ++count) {
           auto request = flooder.request(msg::RequestKind::step);
           request.ticks = 1;
           request.session = 0;
           request.last_sequence = count % 2 == 0 ? 0 : 1'000'000;
           flooder.send(request);
         }
       }},
      {"SnapshotsWithoutEnd", "lockstep",
       [](Flooder& flooder, Probe&) {
         for (int count = 0; count < 500; ++count) {
           flooder.send(flooder.request(msg::RequestKind::take_snapshot));
         }
       }},
      {"NonsenseInEveryField", "lockstep",
       [](Flooder& flooder, Probe&) {
         for (std::uint32_t count = 0; count < 3'000; ++count) {
           auto request = flooder.request(msg::RequestKind{count % 64});
           request.ticks = count % 3;
           request.axes.assign(count % 5, static_cast<std::uint16_t>(flooder.random()));
           request.objects.assign(count % 7, statusword());
           request.rate = -1e300;
           flooder.send(request);
         }
       }},
      {"ProgramsThatComeAndGo", "realtime",
       [](Flooder&, Probe&) {
         for (int count = 0; count < 15; ++count) {
           Flooder visitor;
           ASSERT_TRUE(visitor.is_received());
           visitor.send(visitor.request(msg::RequestKind::read));
         }
       }},
  };
}

/// @param what "VmRSS:" the resident memory of the process, "VmHWM:" its highest value so far [kB]
std::size_t memory_of(const Process& process, const char* what) {
  std::ifstream status("/proc/" + std::to_string(process.id()) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(what)) return std::stoul(line.substr(6));
  }
  return 0;  // it has ended
}

class AFloodedService : public testing::TestWithParam<Flood> {
 protected:
  [[nodiscard]] std::size_t memory() const { return memory_of(service_, "VmRSS:"); }

  /// Floods the service and waits until everything that arrived has been handled.
  void flood() {
    {
      Flooder flooder;
      ASSERT_TRUE(flooder.is_received());
      GetParam().send(flooder, probe_);
    }
    ASSERT_TRUE(probe_.wait_until([&] {
      return probe_.seen_state() && probe_.seen_state()->inbox_depth == 0;
    }));
  }

  Process service_{VDRIVE_SERVICE,
                   tool_arguments(std::string("--log-level off --clock ") + GetParam().clock)};
  Probe probe_{test_domain()};
};

TEST_P(AFloodedService, KeepsItsMemoryBoundedAndServesAGoodClient) {
  ASSERT_TRUE(probe_.find_bench());
  // Queues allocate their pages on first use, so the memory settles only after some floods.
  flood();
  std::size_t before = 0;
  std::size_t after = memory();
  for (int count = 0; count < 5 && after >= before + kLeeway; ++count) {
    before = after;
    flood();
    after = memory();
  }
  EXPECT_GT(after, 0U) << "it has ended";
  EXPECT_LT(after, kMostMemory);
  EXPECT_LT(after, before + kLeeway) << "each flood adds to it";
  const auto reply = probe_.read(1, 0x6041);
  ASSERT_TRUE(reply) << "no client is served";
  EXPECT_EQ(reply->reason, msg::Reason::none);
}

INSTANTIATE_TEST_SUITE_P(Floods, AFloodedService, testing::ValuesIn(floods()),
                         [](const auto& flood) {
                           return std::string(flood.param.name);
                         });

// ---- claimed sizes ------------------------------------------------------------------------------

/// @return the first fragment of an announcement of `size` bytes (RTPS 2.3, 9.4.5.4), in the name
///         of a known participant, because those of unknown ones are refused.
std::vector<std::uint8_t> fragment_of_an_announcement(const wire::Source& source,
                                                      std::uint32_t size, std::uint8_t number) {
  constexpr std::size_t kFragment = 1024;
  std::vector<std::uint8_t> packet{'R', 'T', 'P', 'S', 2, 3, 1, 15};
  const auto add = [&packet](std::initializer_list<std::uint8_t> bytes) {
    packet.insert(packet.end(), bytes);
  };
  packet.insert(packet.end(), source.participant.begin(), source.participant.end());
  add({0x16, 1, (32 + kFragment) % 256, (32 + kFragment) / 256});  // DATA_FRAG, little endian
  add({0, 0, 28, 0, 0, 1, 0, 0xC7, 0, 1, 0, 0xC2});                // from and to discovery
  add({0, 0, 0, 0, number, 0, 0, 1});                              // sequence number
  add({1, 0, 0, 0, 1, 0, kFragment % 256, kFragment / 256});       // the first fragment, alone
  for (int shift = 0; shift < 32; shift += 8) {
    packet.push_back(static_cast<std::uint8_t>(size >> shift));
  }
  packet.resize(packet.size() + kFragment);
  return packet;
}

/// @return an announcement of a different participant for each number, with a lease of `lease`
///         seconds (RTPS 2.3, 8.5.3.2 and 9.6.2.2).
std::vector<std::uint8_t> announcement(std::uint32_t number, std::uint8_t lease = 2) {
  const std::array<std::uint8_t, 12> prefix{1,
                                            15,
                                            0xAB,
                                            0xCD,
                                            static_cast<std::uint8_t>(number),
                                            static_cast<std::uint8_t>(number >> 8U),
                                            static_cast<std::uint8_t>(number >> 16U),
                                            1};
  std::vector<std::uint8_t> packet{'R', 'T', 'P', 'S', 2, 3, 1, 15};
  const auto add = [&packet](std::initializer_list<std::uint8_t> bytes) {
    packet.insert(packet.end(), bytes);
  };
  packet.insert(packet.end(), prefix.begin(), prefix.end());
  add({0x15, 5, 0, 0});                              // DATA to the end of the packet, little endian
  add({0, 0, 16, 0, 0, 1, 0, 0xC7, 0, 1, 0, 0xC2});  // from and to discovery
  add({0, 0, 0, 0, 1, 0, 0, 0});                     // sequence number
  add({0, 3, 0, 0});                                 // a list of parameters
  add({0x15, 0, 4, 0, 2, 3, 0, 0});                  // version
  add({0x16, 0, 4, 0, 1, 15, 0, 0});                 // vendor
  add({0x50, 0, 16, 0});                             // GUID
  packet.insert(packet.end(), prefix.begin(), prefix.end());
  add({0, 0, 1, 0xC1});
  add({2, 0, 8, 0, lease, 0, 0, 0, 0, 0, 0, 0});
  add({0x58, 0, 4, 0, 0x3F, 0, 0, 0});  // endpoints of discovery
  for (const std::uint8_t locator :
       {std::uint8_t{0x32}, std::uint8_t{0x31}}) {  // UDP, port 9, 127.0.0.1
    add({locator, 0, 24, 0, 1, 0, 0, 0, 9, 0, 0,   0, 0, 0,
         0,       0, 0,  0, 0, 0, 0, 0, 0, 0, 127, 0, 0, 1});
  }
  add({1, 0, 0, 0});
  return packet;
}

/// @return an announcement that is larger than any accepted one.
std::vector<std::uint8_t> long_announcement(std::uint32_t number) {
  constexpr std::uint16_t kSize = 20'000;
  std::vector<std::uint8_t> packet = announcement(number);
  std::vector<std::uint8_t> unknown_parameter(kSize + 4);
  unknown_parameter[0] = 0xFF;
  unknown_parameter[1] = 0x7F;
  unknown_parameter[2] = kSize % 256;
  unknown_parameter[3] = kSize / 256;
  packet.insert(packet.end() - 4, unknown_parameter.begin(), unknown_parameter.end());
  return packet;
}

/// Sends to the discovery ports of the service and of the two participants of this test.
void send_to_discovery(const std::vector<std::uint8_t>& packet) {
  const int socket_of_it = socket(AF_INET, SOCK_DGRAM, 0);
  ASSERT_GE(socket_of_it, 0);
  for (std::uint32_t program = 0; program < 3; ++program) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(7410 + 250 * test_domain() + 2 * program));
    sendto(socket_of_it, packet.data(), packet.size(), 0, std::bit_cast<sockaddr*>(&address),
           sizeof address);
  }
  close(socket_of_it);
}

class AService : public testing::Test {
 protected:
  void expect_no_room(std::size_t before) {
    // This session announces itself after the flood, so the flood has been handled when the session
    // is served. The probe may have lost its bench during the flood and, unlike a session, does not
    // search again.
    client::Session session({.domain = test_domain(), .find_timeout = 60s});
    auto axis = session.axis("1.1");
    ASSERT_TRUE(axis) << "no client is served";
    EXPECT_TRUE(axis->read({0x6041}));
    EXPECT_LT(memory_of(service_, "VmHWM:"), before + kLeeway);
  }

  Process service_{VDRIVE_SERVICE, tool_arguments("--log-level off --clock realtime")};
  Probe probe_{test_domain()};
  Flooder flooder_;
};

// A million axes with four objects each take more than 72 MB; the largest permitted frame has
// 41 kB.
TEST_F(AService, AllocatesNothingForAMessageLargerThanItsType) {
  ASSERT_TRUE(probe_.find_bench());
  ASSERT_TRUE(flooder_.is_received());
  const std::size_t before = memory_of(service_, "VmHWM:");
  auto frame = flooder_.frame();
  fill(frame, 1'000'000, 4);
  flooder_.send(frame);
  expect_no_room(before);
}

TEST_F(AService, AllocatesNothingForAnAnnouncementThatClaimsAGigabyte) {
  ASSERT_TRUE(probe_.find_bench());
  ASSERT_TRUE(flooder_.is_received());
  const std::size_t before = memory_of(service_, "VmHWM:");
  for (std::uint8_t number = 1; number < 10; ++number) {
    send_to_discovery(fragment_of_an_announcement(flooder_.source(), 1U << 30U, number));
  }
  expect_no_room(before);
}

// The library checks an announcement only once, so the program must announce itself again.
TEST_F(AService, AdmitsAWaitingProgramAsSoonAsAPlaceIsFree) {
  constexpr std::uint8_t kLease = 4;  // [s]; longer than sending all of them takes
  constexpr std::uint32_t kMany = 2'000;
  ASSERT_TRUE(probe_.find_bench());
  std::chrono::steady_clock::duration search_time{};
  // Our announcement may overtake some of the others, so try again.
  for (std::uint32_t number = 0; search_time < 1s; number += kMany) {
    ASSERT_LT(number, 20 * kMany) << "there was always a place: nothing is shown";
    for (std::uint32_t other = number; other < number + kMany; ++other) {
      send_to_discovery(announcement(other, kLease));
    }
    const auto start = std::chrono::steady_clock::now();
    client::Session session({.domain = test_domain(), .find_timeout = 60s});
    ASSERT_TRUE(session.find_bench(1));
    search_time = std::chrono::steady_clock::now() - start;
  }
}

TEST(AServiceThatLogs, LimitsMessagesOfItsLibraryToOneASecond) {
  constexpr std::uint32_t kMany = 5'000;
  const wire::LibraryLog quiet([](const std::string&, const std::string&) {});
  const auto start = std::chrono::steady_clock::now();
  Process service(VDRIVE_SERVICE, tool_arguments("--log-level warn --clock realtime"));
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  for (std::uint32_t number = 0; number < kMany; ++number) {
    send_to_discovery(long_announcement(number));
  }
  ASSERT_TRUE(probe.read(1, 0x6041)) << "no client is served";
  service.send(SIGTERM);
  const std::string log = service.wait().errors;
  const auto seconds = std::chrono::steady_clock::now() - start;
  const std::string mark = " [warning] dds=";
  std::chrono::seconds lines{0};
  for (auto at = log.find(mark); at != std::string::npos; at = log.find(mark, at + 1)) ++lines;
  EXPECT_GE(lines, 1s) << log;
  EXPECT_LE(lines, seconds + 1s) << log;
  EXPECT_LT(log.size(), 1000 * static_cast<std::size_t>(lines.count()) + 1000) << "other lines";
}

TEST_F(AService, AdmitsABoundedNumberOfParticipants) {
  ASSERT_TRUE(probe_.find_bench());
  const std::size_t before = memory_of(service_, "VmHWM:");
  for (std::uint32_t number = 0; number < 20'000; ++number) send_to_discovery(announcement(number));
  expect_no_room(before);
}

}  // namespace
}  // namespace vdrive::test

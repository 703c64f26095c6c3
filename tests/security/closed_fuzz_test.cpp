// SPDX-License-Identifier: Apache-2.0
// Sends a closed bench and its client the datagrams of this run, changed in the fields that are in
// clear. Recordings of earlier runs would not do: the keys are new in each run, and datagrams of
// unknown participants never reach the decryption.
#include "guard/datagram_check.hpp"
#include "guard/rtps.hpp"
#include "security/material.hpp"
#include "support/effort.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "wire/datagrams.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace fs = std::filesystem;

/// A datagram and its destination port.
struct Captured {
  std::uint16_t port = 0;
  Datagram datagram;
};

/// Kinds of datagrams, as seen in clear. Rare kinds are changed as often as frequent ones.
enum class Content : std::uint8_t { message, keys, handshake, announcement, other };
constexpr std::size_t kContents = 5;
constexpr std::array<const char*, kContents> kContentNames{
    "encrypted messages", "exchanges of keys", "handshakes", "announcements", "other"};

Content content_of(const Datagram& datagram) {
  wire::Submessages submessages(datagram);
  wire::Submessage submessage;
  while (!submessages.at_end() && submessages.next(submessage)) {
    using wire::SubmessageKind;
    if (submessage.kind == SubmessageKind::srtps_prefix) return Content::message;
    if (submessage.kind == SubmessageKind::sec_prefix) return Content::keys;
    if (submessage.kind != SubmessageKind::data) continue;
    const auto data = wire::parse_data(submessage, wire::kDataFixed);
    if (data.writer == wire::kHandshakeWriter) return Content::handshake;
    if (data.writer == wire::kParticipantsWriter) return Content::announcement;
  }
  return Content::other;
}

/// Captures the datagrams of a domain on loopback; keeps some of each content, including the
/// newest.
class Capture {
 public:
  /// @param own_port the port from which this test sends
  explicit Capture(std::uint16_t own_port)
      : own_port_(own_port),
        first_port_(static_cast<std::uint16_t>(7400 + 250 * test_domain())),
        socket_(socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IP))) {
    if (socket_ < 0) return;
    sockaddr_ll address{};
    address.sll_family = AF_PACKET;
    address.sll_protocol = htons(ETH_P_IP);
    address.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
    static_cast<void>(bind(socket_, std::bit_cast<sockaddr*>(&address), sizeof address));
    const timeval patience{.tv_sec = 0, .tv_usec = 100'000};
    static_cast<void>(setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience));
    reader_ = std::thread([this] {
      while (!ends_) read();
    });
  }

  ~Capture() {
    ends_ = true;
    if (reader_.joinable()) reader_.join();
    if (socket_ >= 0) close(socket_);
  }

  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  [[nodiscard]] bool is_permitted() const { return socket_ >= 0; }

  [[nodiscard]] std::array<std::size_t, kContents> counts() {
    const std::scoped_lock lock(mutex_);
    return counts_;
  }

  /// @return a captured datagram; each content has the same probability.
  Captured any(std::mt19937_64& random) {
    const std::scoped_lock lock(mutex_);
    std::vector<Captured>* kept = nullptr;
    while (kept == nullptr || kept->empty()) kept = &kept_.at(random() % kContents);
    return kept->at(random() % kept->size());
  }

 private:
  static constexpr std::size_t kKept = 64;  ///< per content
  static constexpr std::size_t kUdpHeader = 8;

  void read() {
    Datagram packet(65'536);
    sockaddr_ll from{};
    socklen_t size = sizeof from;
    const ssize_t length =
        recvfrom(socket_, packet.data(), packet.size(), 0, std::bit_cast<sockaddr*>(&from), &size);
    // Loopback shows each packet twice: when it is sent and when it is received.
    if (length < 28 || from.sll_pkttype == PACKET_OUTGOING || packet[9] != IPPROTO_UDP) return;
    packet.resize(static_cast<std::size_t>(length));
    const std::size_t ip_header = std::size_t{4} * (packet[0] & 15U);
    if (packet.size() < ip_header + kUdpHeader) return;
    const auto port_at = [&](std::size_t place) {
      return static_cast<std::uint16_t>(packet[place] << 8U | packet[place + 1]);
    };
    const std::uint16_t port = port_at(ip_header + 2);
    if (port < first_port_ || port >= first_port_ + 250 || port_at(ip_header) == own_port_) return;
    packet.erase(packet.begin(),
                 packet.begin() + static_cast<std::ptrdiff_t>(ip_header + kUdpHeader));
    keep({port, std::move(packet)});
  }

  void keep(Captured captured) {
    const auto content = static_cast<std::size_t>(content_of(captured.datagram));
    const std::scoped_lock lock(mutex_);
    std::vector<Captured>& kept = kept_.at(content);
    const std::size_t place = counts_.at(content)++ % kKept;
    if (place < kept.size()) {
      kept[place] = std::move(captured);
    } else {
      kept.push_back(std::move(captured));
    }
  }

  std::uint16_t own_port_;
  std::uint16_t first_port_;
  int socket_;
  std::mutex mutex_;
  std::array<std::vector<Captured>, kContents> kept_;
  std::array<std::size_t, kContents> counts_{};
  std::atomic<bool> ends_{false};
  std::thread reader_;
};

/// Changes parts that are in clear: headers, lengths, counts, prefixes, order.
class ClearFieldMutator {
 public:
  void change(Datagram& datagram, std::mt19937_64& random) {
    random_ = &random;
    const std::vector<std::size_t> parts = submessages(datagram);
    switch (below(8)) {
      case 0:
        return number(datagram, length_of_body(datagram, parts));
      case 1:
        return number(datagram, 20 + below(datagram.size() - 20) / 4 * 4);
      case 2:
        datagram[20 + below(datagram.size() - 20)] ^= static_cast<std::uint8_t>(1U << below(8));
        return;
      case 3:
        return length(datagram, parts.at(below(parts.size())));
      case 4:
        datagram[parts.at(below(parts.size()))] = static_cast<std::uint8_t>(0x30 + below(5));
        return;
      case 5:
        return move(datagram, parts);
      case 6:
        datagram.resize(24 + below(datagram.size()));
        return;
      default:
        return postfix(datagram, parts);
    }
  }

 private:
  std::size_t below(std::size_t bound) { return bound == 0 ? 0 : (*random_)() % bound; }

  static std::vector<std::size_t> submessages(const Datagram& datagram) {
    std::vector<std::size_t> offsets;
    for (std::size_t offset = 20; offset + 4 <= datagram.size();) {
      offsets.push_back(offset);
      offset += 4U + datagram[offset + 2] + 256U * datagram[offset + 3];
    }
    return offsets.empty() ? std::vector<std::size_t>{20} : offsets;
  }

  static std::size_t length_of_body(const Datagram& datagram,
                                    const std::vector<std::size_t>& parts) {
    const auto found = std::ranges::find_if(parts, [&](std::size_t part) {
      return datagram[part] == 0x30;
    });
    return found == parts.end() ? parts.back() + 4 : *found + 4;
  }

  /// Replaces a 32-bit number with one that is likely to upset sums and comparisons.
  void number(Datagram& datagram, std::size_t place) {
    if (place + 4 > datagram.size()) return;
    constexpr std::array<std::uint32_t, 10> kNumbers{
        0, 1, 4, 0xFFFF, 0x10000, 0x01000000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFC, 0xFFFFFFFF};
    std::uint32_t value = kNumbers.at(below(kNumbers.size()));
    if (below(3) == 0) value += static_cast<std::uint32_t>(datagram.size() + below(64)) - 32;
    const bool big = below(2) == 0;
    for (std::size_t byte = 0; byte < 4; ++byte) {
      datagram[place + byte] = static_cast<std::uint8_t>(value >> 8 * (big ? 3 - byte : byte));
    }
  }

  void length(Datagram& datagram, std::size_t part) {
    if (part + 4 > datagram.size()) return;
    constexpr std::array<std::uint16_t, 6> kLengths{0, 4, 16, 20, 0xFFFC, 0xFFFF};
    const std::uint16_t value = kLengths.at(below(kLengths.size()));
    datagram[part + 2] = static_cast<std::uint8_t>(value);
    datagram[part + 3] = static_cast<std::uint8_t>(value >> 8U);
  }

  /// Omits a submessage, repeats it at the end, or moves it there.
  void move(Datagram& datagram, const std::vector<std::size_t>& parts) {
    const std::size_t which = below(parts.size());
    const std::size_t from = std::min(parts.at(which), datagram.size());
    const std::size_t to =
        which + 1 < parts.size() ? std::min(parts.at(which + 1), datagram.size()) : datagram.size();
    const auto at = [&](std::size_t place) {
      return datagram.begin() + static_cast<std::ptrdiff_t>(place);
    };
    const Datagram part(at(from), at(to));
    const std::size_t how = below(3);
    if (how != 1) datagram.erase(at(from), at(to));
    if (how != 0) datagram.insert(datagram.end(), part.begin(), part.end());
    if (datagram.size() < 24) datagram.resize(24);
  }

  /// Changes the number of MACs, with or without the matching number of them.
  void postfix(Datagram& datagram, const std::vector<std::size_t>& parts) {
    const std::size_t part = parts.back();
    if (part + 24 > datagram.size()) return;
    const std::size_t macs = below(4);
    number(datagram, part + 20);
    if (below(2) == 0) return;
    datagram[part + 23] = static_cast<std::uint8_t>(macs);
    datagram[part + 20] = datagram[part + 21] = datagram[part + 22] = 0;
    datagram.resize(part + 24 + 20 * macs);
    datagram[part + 2] = static_cast<std::uint8_t>(20 + 20 * macs);
    datagram[part + 3] = 0;
  }

  std::mt19937_64* random_ = nullptr;
};

/// Sends on loopback from a separate port.
class Sender {
 public:
  Sender() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = loopback(0);
    static_cast<void>(bind(socket_, std::bit_cast<sockaddr*>(&address), sizeof address));
  }

  ~Sender() { close(socket_); }

  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  [[nodiscard]] std::uint16_t port() const {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    static_cast<void>(getsockname(socket_, std::bit_cast<sockaddr*>(&address), &size));
    return ntohs(address.sin_port);
  }

  void send(const Captured& captured) const {
    sockaddr_in address = loopback(captured.port);
    static_cast<void>(sendto(socket_, captured.datagram.data(), captured.datagram.size(), 0,
                             std::bit_cast<sockaddr*>(&address), sizeof address));
  }

 private:
  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
  }

  int socket_;
};

/// @return the number of datagrams for which the domain's open sockets had no room.
std::uint64_t lost_in_sockets() {
  std::ifstream file("/proc/net/udp");
  std::uint64_t lost = 0;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    const unsigned long port = std::strtoul(line.c_str() + line.find(':', 8) + 1, nullptr, 16);
    const unsigned long first = 7400 + 250 * test_domain();
    if (port < first || port >= first + 250) continue;
    const std::size_t end = line.find_last_not_of(' ');
    lost += std::strtoul(line.c_str() + line.rfind(' ', end) + 1, nullptr, 10);
  }
  return lost;
}

bool has_ended(const Process& process) {
  siginfo_t info{};
  return waitid(P_PID, static_cast<id_t>(process.id()), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         info.si_pid != 0;
}

/// A closed bench and a client. The wire of the bench is a thread, so if the wire dies the service
/// does, too.
class FuzzedBench : public testing::Test {
 protected:
  void SetUp() override {
    if (!capture_.is_permitted()) GTEST_SKIP() << "no packet socket is permitted (CAP_NET_RAW)";
    service_.emplace(VDRIVE_SERVICE,
                     tool_arguments("--wire thread --log-level off --axes 4 --security " +
                                    authority_.member("service bench").string()));
    ASSERT_EQ(as_controller("list").code, 0);
    start_client();
    const auto deadline = Clock::now() + 60s;
    while (!has_each_content() && Clock::now() < deadline) {
      ASSERT_EQ(as_controller("read 1.1 0x6041").code, 0);
    }
    ASSERT_TRUE(has_each_content());
  }

  Finished as_controller(const std::string& words) const {
    return tool(words + " --timeout 40 --security " + controller_.string());
  }

  void start_client() {
    client_ = std::make_unique<Process>(
        "/bin/sh",
        std::vector<std::string>{"-c", "exec \"$0\" \"$@\" >/dev/null", VDRIVE_TOOL, "watch", "1.1",
                                 "--domain", std::to_string(test_domain()), "--timeout", "40",
                                 "--security", controller_.string()});
  }

  /// A client may end without an error, because anybody can announce the end of its bench.
  [[nodiscard]] bool replace_ended_client() {
    if (!has_ended(*client_)) return true;
    const Finished ended = client_->wait();
    if (ended.code < 0) {
      ADD_FAILURE() << "the client ended by signal " << -ended.code;
      return false;
    }
    ++clients_ended_;
    start_client();
    return true;
  }

  /// Sends `count` changed datagrams of this run. @return whether service and client survive.
  [[nodiscard]] bool attack(std::uint64_t count) {
    for (std::uint64_t number = 0; number < count; ++number) {
      Captured captured = capture_.any(random_);
      if (random_() % 16 != 0) {
        for (std::size_t changes = 1 + random_() % 2; changes > 0; --changes) {
          mutator_.change(captured.datagram, random_);
        }
      }
      note(captured.datagram);
      sender_.send(captured);
      // Short pauses let the programs read their sockets, which drop datagrams when they are full.
      if (number % 64 == 0) std::this_thread::sleep_for(1ms);
      if (number % 1024 != 0) continue;
      if (has_ended(*service_)) {
        ADD_FAILURE() << "the service ended after " << number << " datagrams";
        return false;
      }
      if (!replace_ended_client()) return false;
    }
    return true;
  }

  void note(const Datagram& datagram) {
    const auto report = wire::check_datagram(datagram, wire::Mode::closed);
    if (report.refusal == wire::Refusal::none) {
      ++passed_.at(static_cast<std::size_t>(content_of(datagram)));
    } else {
      ++dropped_[report.refusal];
    }
  }

  void print() {
    const auto captured = capture_.counts();
    for (std::size_t content = 0; content < kContents; ++content) {
      std::cout << kContentNames.at(content) << ": captured " << captured.at(content)
                << ", passed to the library " << passed_.at(content) << "\n";
    }
    for (const auto& [refusal, count] : dropped_) {
      std::cout << "dropped, " << wire::describe(refusal) << ": " << count << "\n";
    }
    std::cout << "clients that ended by themselves: " << clients_ended_
              << ", lost in full sockets: " << lost_in_sockets() << "\n";
  }

  bool has_each_content() {
    const auto counts = capture_.counts();
    return std::ranges::all_of(counts.begin(), counts.begin() + 4, [](std::size_t count) {
      return count >= 8;
    });
  }

  Authority authority_;
  fs::path controller_ = authority_.member("controller desk");
  Sender sender_;
  Capture capture_{sender_.port()};
  std::optional<Process> service_;
  std::unique_ptr<Process> client_;
  ClearFieldMutator mutator_;
  std::mt19937_64 random_{1};
  std::array<std::uint64_t, kContents> passed_{};
  std::map<wire::Refusal, std::uint64_t> dropped_;
  std::uint64_t clients_ended_ = 0;
};

TEST_F(FuzzedBench, SurvivesItsOwnDatagramsWithOtherClearFields) {
  const bool lives =
      attack(number_of<std::uint64_t>({.usual = 15'000, .full = 50'000, .nightly = 1'000'000}));
  print();
  ASSERT_TRUE(lives);
  EXPECT_EQ(as_controller("read 1.1 0x6041").code, 0) << "no new client is served";
  client_->send(SIGINT);
  EXPECT_GE(client_->wait().code, 0);
  service_->send(SIGTERM);
  EXPECT_EQ(service_->wait().code, 0);
}

}  // namespace
}  // namespace vdrive::test

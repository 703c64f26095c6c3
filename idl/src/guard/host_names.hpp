// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dds/library/library.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::wire {

/// Hosts that are named. The library takes addresses, and keeps them for as long as its participant
/// lives; a name may lead elsewhere at any time. So the library gets a stand-in for each name, an
/// address of 240.0.0.0/4 that no host has (RFC 1112, clause 4), and what it sends there goes to
/// where the name leads at that moment. What it sends to a former address of a server also does:
/// Fast DDS 2.9 answers a server that has moved at the address that it announced before
/// (PDPClient::removeRemoteEndpoints). It goes by sockets of this object: those of the library
/// count by address, and Debian's build of 2.9 ends at an address that it was not told of before
/// (OutputTrafficManager::set_statistics_message_data). The library itself sends to one, on the
/// host of a discovery server that it has given up. Thread-safe.
class HostNames {
 public:
  using Addresses = std::vector<std::string>;

  /// Where a name leads, or why it leads nowhere.
  struct Answer {
    Addresses addresses{};  ///< IPv4
    std::string problem{};  ///< in words, when there are none
  };

  using Resolver = std::function<Answer(const std::string& name)>;

  /// How often a name is looked up again.
  static constexpr std::chrono::seconds kInterval{2};
  /// How long start() waits for the first answers.
  static constexpr std::chrono::milliseconds kFirstAnswer{500};

  /// @param resolver may take any time; by default that of the system
  explicit HostNames(Resolver resolver = system_answer);

  /// A look-up that is under way goes on without this.
  ~HostNames();
  HostNames(const HostNames&) = delete;
  HostNames& operator=(const HostNames&) = delete;

  /// Before start(). @param port of a server; 0 = any, of a peer
  /// @return what the library shall call the host: an address itself, or the stand-in of a name.
  [[nodiscard]] std::string stand_in(const std::string& host, std::uint16_t port);

  /// Begins to look names up, each in a thread of its own, and waits for the first answers. Names
  /// of /etc/hosts keep the address that they have there: the wire of a service opens no file
  /// later.
  /// @param own addresses by which datagrams leave
  void start(const Addresses& own);

  /// @return whether there are names: otherwise destinations() changes nothing.
  [[nodiscard]] bool has_names() const noexcept { return has_names_; }

  /// @return where a datagram to `wanted` goes instead, empty = nowhere; nothing for an address.
  [[nodiscard]] std::optional<std::vector<rtps::Locator_t>> destinations(
      const rtps::Locator_t& wanted) const;

  /// By each own address, as the library does: the kernel refuses those that do not lead there.
  /// What the network does not take at once is lost, as any datagram may be.
  void send(std::span<const std::uint8_t> datagram, const rtps::Locator_t& to) const;

  /// @return a line for each name that leads nowhere, or did so at the last look.
  [[nodiscard]] std::vector<std::string> troubles() const;

  /// Looks each name up once. For tests.
  void look_up();

  /// getaddrinfo()
  [[nodiscard]] static Answer system_answer(const std::string& name);

  /// @param hosts the text of /etc/hosts
  /// @return the IPv4 addresses of a name in it.
  [[nodiscard]] static Addresses addresses_in(const std::string& hosts, const std::string& name);

 private:
  struct State;
  static void look_up(State& state, std::size_t place);

  bool has_names_ = false;
  std::vector<int> sockets_;      ///< each bound to an own address
  std::shared_ptr<State> state_;  ///< shared with the threads, which nobody waits for
};

}  // namespace vdrive::wire

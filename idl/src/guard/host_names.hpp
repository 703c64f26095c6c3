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

/// Hosts given by name. The library takes only addresses, for the lifetime of its participant, but
/// a name may change its address at any time. So the library gets a stand-in for each name, an
/// address from 240.0.0.0/4 that no host has (RFC 1112, clause 4), and what it sends there goes to
/// the present addresses of the name. The same applies to datagrams for a former address of a
/// server: when a server has moved, Fast DDS 2.9 still sends its answers to the address that the
/// server announced before (PDPClient::removeRemoteEndpoints). These datagrams leave from sockets
/// of this object, because the library keeps statistics by address, and Debian's build of 2.9
/// crashes at an address that was never announced to it
/// (OutputTrafficManager::set_statistics_message_data). After giving up a discovery server, the
/// library itself sends to an unannounced address on the host of that server; these datagrams leave
/// from here too. Thread-safe.
class HostNames {
 public:
  using Addresses = std::vector<std::string>;

  /// The addresses of a name, or why it has none.
  struct Answer {
    Addresses addresses{};  ///< IPv4
    std::string problem{};  ///< as text, if there are none
  };

  using Resolver = std::function<Answer(const std::string& name)>;

  /// How often a name is looked up again.
  static constexpr std::chrono::seconds kInterval{2};
  /// How long start() waits for the first answers.
  static constexpr std::chrono::milliseconds kFirstAnswer{500};

  /// @param resolver may take any time; by default that of the system
  explicit HostNames(Resolver resolver = system_answer);

  /// A look-up in progress continues without this object.
  ~HostNames();
  HostNames(const HostNames&) = delete;
  HostNames& operator=(const HostNames&) = delete;

  /// Call before start(). @param port of a server; 0 = any, for a peer
  /// @return the address that the library must use for the host: an address itself, or the stand-in
  ///         of a name.
  [[nodiscard]] std::string stand_in(const std::string& host, std::uint16_t port);

  /// Starts looking up names, each in its own thread, and waits for the first answers. Names in
  /// /etc/hosts keep the address given there, because the wire of a service opens no file later.
  /// @param own addresses from which datagrams leave
  void start(const Addresses& own);

  /// @return whether there are names; otherwise destinations() changes nothing.
  [[nodiscard]] bool has_names() const noexcept { return has_names_; }

  /// @return where to send a datagram for `wanted` instead, empty = nowhere; nothing for an
  ///         ordinary address.
  [[nodiscard]] std::optional<std::vector<rtps::Locator_t>> destinations(
      const rtps::Locator_t& wanted) const;

  /// Sends from each of our addresses, like the library: the kernel refuses those from which there
  /// is no route. Does not block, so a datagram that the network does not take immediately is lost.
  void send(std::span<const std::uint8_t> datagram, const rtps::Locator_t& to) const;

  /// @return a line for each name without an address, or whose last look-up failed.
  [[nodiscard]] std::vector<std::string> troubles() const;

  /// Looks up each name once. For tests.
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
  std::vector<int> sockets_;      ///< each bound to one of our addresses
  std::shared_ptr<State> state_;  ///< shared with the threads, which nobody joins
};

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#include "guard/host_names.hpp"

#include "vdrive/text.hpp"
#include "vdrive/wire/address.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <condition_variable>
#include <cstring>
#include <fstream>
#include <iterator>
#include <mutex>
#include <sstream>
#include <thread>
#include <utility>

namespace vdrive::wire {
namespace {

using rtps::IPLocator;

constexpr std::size_t kMostFormer = 16;

struct Name {
  std::string host;
  std::uint16_t port = 0;  ///< 0 = any
  std::string stand_in;
  HostNames::Addresses addresses{};  ///< present addresses
  HostNames::Addresses former{};     ///< former addresses of a server, newest last
  std::string problem{};             ///< at the last look-up
};

/// Turns the present addresses of a server into former ones.
/// @param own addresses of this host
void retire_addresses(const HostNames::Addresses& own, Name& name) {
  for (const std::string& address : name.addresses) {
    name.former.push_back(address);
    // The library uses loopback for a server on its own host.
    if (std::ranges::count(own, address) != 0) name.former.emplace_back(kLoopback);
  }
  while (name.former.size() > kMostFormer) name.former.erase(name.former.begin());
}

/// @return a socket that sends from this address; -1 if there is none.
int bound_socket(const std::string& address) {
  const int made = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  if (inet_pton(AF_INET, address.c_str(), &own.sin_addr) == 1 &&
      bind(made, std::bit_cast<sockaddr*>(&own), sizeof own) == 0) {
    return made;
  }
  if (made >= 0) close(made);
  return -1;
}

void take(HostNames::Answer&& answer, const HostNames::Addresses& own, Name& name) {
  name.problem = std::move(answer.problem);
  // If the name server is away, participants that have found each other must stay connected.
  if (answer.addresses.empty() || answer.addresses == name.addresses) return;
  if (name.port != 0) retire_addresses(own, name);
  name.addresses = std::move(answer.addresses);
  std::erase_if(name.former, [&name](const std::string& address) {
    return std::ranges::count(name.addresses, address) != 0;
  });
}

}  // namespace

struct HostNames::State {
  explicit State(Resolver its_resolver) : resolver(std::move(its_resolver)) {}

  const Resolver resolver;
  mutable std::mutex mutex;  ///< guards the members below
  std::condition_variable changed;
  std::vector<Name> names;
  HostNames::Addresses own{};
  std::size_t looked = 0;  ///< names that have been looked up
  bool ends = false;
};

HostNames::HostNames(Resolver resolver) : state_(std::make_shared<State>(std::move(resolver))) {}

HostNames::~HostNames() {
  for (const int each : sockets_) close(each);
  const std::scoped_lock lock(state_->mutex);
  state_->ends = true;
  state_->changed.notify_all();
}

std::string HostNames::stand_in(const std::string& host, std::uint16_t port) {
  if (is_address(host)) return host;
  has_names_ = true;
  const std::scoped_lock lock(state_->mutex);
  constexpr std::size_t kOctet = 256;
  const std::size_t number = state_->names.size() + 1;
  std::string address =
      "240.0." + std::to_string(number / kOctet) + "." + std::to_string(number % kOctet);
  state_->names.push_back({.host = host, .port = port, .stand_in = address});
  return address;
}

void HostNames::start(const Addresses& own) {
  std::unique_lock lock(state_->mutex);
  for (const std::string& address : own) {
    const int made = bound_socket(address);
    if (made >= 0) sockets_.push_back(made);
  }
  if (!has_names_) return;
  state_->own = own;
  std::ifstream file("/etc/hosts");
  const std::string hosts{std::istreambuf_iterator<char>(file), {}};
  for (std::size_t place = 0; place < state_->names.size(); ++place) {
    Name& name = state_->names[place];
    name.addresses = addresses_in(hosts, name.host);
    if (!name.addresses.empty()) {
      ++state_->looked;
      continue;
    }
    // Detached: a look-up may take longer than a program is willing to wait at its end.
    std::thread([state = state_, place] {
      while (true) {
        look_up(*state, place);
        std::unique_lock waiting(state->mutex);
        if (state->changed.wait_for(waiting, kInterval, [&state] {
              return state->ends;
            })) {
          return;
        }
      }
    }).detach();
  }
  state_->changed.wait_for(lock, kFirstAnswer, [this] {
    return state_->looked >= state_->names.size();
  });
}

void HostNames::look_up() {
  for (std::size_t place = 0; place < state_->names.size(); ++place) look_up(*state_, place);
}

void HostNames::look_up(State& state, std::size_t place) {
  std::string host;
  {
    const std::scoped_lock lock(state.mutex);
    host = state.names[place].host;
  }
  Answer answer = state.resolver(host);
  const std::scoped_lock lock(state.mutex);
  take(std::move(answer), state.own, state.names[place]);
  ++state.looked;
  state.changed.notify_all();
}

std::optional<std::vector<rtps::Locator_t>> HostNames::destinations(
    const rtps::Locator_t& wanted) const {
  if (!has_names_ || wanted.kind != LOCATOR_KIND_UDPv4) return std::nullopt;
  const std::string address = IPLocator::toIPv4string(wanted);
  const std::uint32_t port = wanted.port;
  const std::scoped_lock lock(state_->mutex);
  const auto leads = [&](const Name& name) {
    return name.stand_in == address ||
           (name.port == port && std::ranges::count(name.former, address) != 0);
  };
  const std::vector<Name>& names = state_->names;
  // A former address of one server may be the present address of another.
  const bool is_present = std::ranges::any_of(names, [&](const Name& name) {
    return name.port == port && std::ranges::count(name.addresses, address) != 0;
  });
  const auto name = std::ranges::find_if(names, leads);
  if (is_present || name == names.end()) return std::nullopt;
  std::vector<rtps::Locator_t> destinations;
  for (const std::string& own : name->addresses) {
    IPLocator::setIPv4(destinations.emplace_back(wanted), own);
  }
  return destinations;
}

void HostNames::send(std::span<const std::uint8_t> datagram, const rtps::Locator_t& to) const {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(to.port));
  std::memcpy(&address.sin_addr, IPLocator::getIPv4(to), sizeof address.sin_addr);
  for (const int each : sockets_) {
    static_cast<void>(sendto(each, datagram.data(), datagram.size(), MSG_DONTWAIT,
                             std::bit_cast<sockaddr*>(&address), sizeof address));
  }
}

std::vector<std::string> HostNames::troubles() const {
  const std::scoped_lock lock(state_->mutex);
  std::vector<std::string> troubles;
  for (const Name& name : state_->names) {
    if (name.problem.empty()) continue;
    const std::string last = joined(name.addresses);
    troubles.push_back("the host name " + in_quotes(name.host) + " does not resolve: " +
                       name.problem + (last.empty() ? "" : "; its last address is used: " + last));
  }
  return troubles;
}

HostNames::Answer HostNames::system_answer(const std::string& name) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* first = nullptr;
  const int code = getaddrinfo(name.c_str(), nullptr, &hints, &first);
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(first, &freeaddrinfo);
  if (code != 0) return {.addresses = {}, .problem = gai_strerror(code)};
  Answer answer;
  for (const addrinfo* one = first; one != nullptr; one = one->ai_next) {
    // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface gives
    const auto* const address = reinterpret_cast<const sockaddr_in*>(one->ai_addr);
    std::array<char, INET_ADDRSTRLEN> text{};
    inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
    answer.addresses.emplace_back(text.data());
  }
  std::ranges::sort(answer.addresses);  // name servers rotate them
  answer.addresses.erase(std::unique(answer.addresses.begin(), answer.addresses.end()),
                         answer.addresses.end());
  return answer;
}

HostNames::Addresses HostNames::addresses_in(const std::string& hosts, const std::string& name) {
  Addresses addresses;
  std::istringstream lines(hosts);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string address;
    words >> address;
    for (std::string word; words >> word;) {
      if (word == name && is_address(address)) addresses.push_back(address);
    }
  }
  return addresses;
}

}  // namespace vdrive::wire

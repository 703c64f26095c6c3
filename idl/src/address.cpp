// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/address.hpp"

#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>

#include <algorithm>
#include <array>
#include <memory>

namespace vdrive::wire {
namespace {

bool is_letter(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

bool is_part_of_a_name(char c) noexcept {
  return is_letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '_';
}

bool is_label(std::string_view text) noexcept {
  constexpr std::size_t kLongestLabel = 63;  // RFC 1035, 2.3.4
  return !text.empty() && text.size() <= kLongestLabel && text.front() != '-' &&
         std::ranges::all_of(text, is_part_of_a_name);
}

}  // namespace

bool is_address(const std::string& text) {
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

bool is_host(const std::string& text) {
  if (is_address(text)) return true;
  constexpr std::size_t kLongestName = 253;  // RFC 1035, 2.3.4
  if (text.size() > kLongestName) return false;
  std::string_view rest = text;
  if (rest.ends_with('.')) rest.remove_suffix(1);
  while (true) {
    const auto dot = rest.find('.');
    const std::string_view label = rest.substr(0, dot);
    if (!is_label(label)) return false;
    if (dot == std::string_view::npos) return std::ranges::any_of(label, is_letter);
    rest.remove_prefix(dot + 1);
  }
}

bool is_interface(const std::string& text) {
  const auto is_allowed = [](char c) {
    return is_part_of_a_name(c) || c == '.' || c == ':' || c == '@';
  };
  return is_address(text) || (text.size() < IF_NAMESIZE && std::ranges::any_of(text, is_letter) &&
                              std::ranges::all_of(text, is_allowed));
}

bool is_loopback(std::string_view address) noexcept {
  return address.starts_with("127.");
}

std::optional<ServerAddress> parse_server_address(std::string_view text) {
  const auto colon = text.find(':');
  const std::string host(text.substr(0, colon));
  if (colon == std::string_view::npos || !is_host(host)) return std::nullopt;
  const auto port = parse_digits<std::uint16_t>(text.substr(colon + 1));
  if (!port || *port == 0) return std::nullopt;
  return ServerAddress{host, *port};
}

std::vector<OwnInterface> own_interfaces() {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(first, &freeifaddrs);
  std::vector<OwnInterface> interfaces;
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface gives
    const auto* const address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    std::array<char, INET_ADDRSTRLEN> text{};
    inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
    interfaces.push_back(
        {.name = one->ifa_name, .address = text.data(), .is_up = (one->ifa_flags & IFF_UP) != 0U});
  }
  return interfaces;
}

std::string to_text(const std::vector<OwnInterface>& interfaces) {
  std::vector<std::string> words;
  words.reserve(interfaces.size());
  for (const OwnInterface& one : interfaces) words.push_back(one.address + " (" + one.name + ")");
  return joined(words);
}

std::vector<std::string> addresses_of(const std::string& interface,
                                      const std::vector<OwnInterface>& own) {
  std::vector<std::string> addresses;
  for (const OwnInterface& one : own) {
    if (one.is_up && (one.address == interface || one.name == interface)) {
      addresses.push_back(one.address);
    }
  }
  return addresses;
}

}  // namespace vdrive::wire

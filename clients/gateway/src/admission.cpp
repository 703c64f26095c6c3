// SPDX-License-Identifier: Apache-2.0
#include "admission.hpp"

#include "protocol.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace vdrive::gateway {
namespace {

constexpr std::string_view kBearer = "Bearer ";
constexpr std::string_view kTokenKey = "token=";

bool is_same_text(std::string_view a, std::string_view b) {
  const auto lower = [](char c) {
    return std::tolower(static_cast<unsigned char>(c));
  };
  return std::ranges::equal(a, b, {}, lower, lower);
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// The host without its port.
std::string_view name_of(std::string_view host) {
  if (host.starts_with('[')) return host.substr(0, host.find(']') + 1);
  return host.substr(0, host.find(':'));
}

bool is_address(std::string_view name) {
  if (name.starts_with('[')) return name.ends_with(']');  // IPv6
  return !name.empty() && std::ranges::all_of(name, [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.';
  });
}

/// The origin of the gateway's own page is the host of the request, with https if a proxy adds TLS.
bool is_own_origin(const UpgradeRequest& request, const AdmissionRules& rules) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (is_same_text(request.origin, std::string(scheme).append(request.host))) return true;
  }
  return std::ranges::any_of(rules.origins, [&](const std::string& origin) {
    return is_same_text(origin, request.origin);
  });
}

std::string_view token_of(const UpgradeRequest& request) {
  if (request.authorization.starts_with(kBearer)) {
    return trimmed(request.authorization.substr(kBearer.size()));
  }
  const auto query = request.target.find('?');
  if (query == std::string_view::npos) return {};
  std::string_view rest = request.target.substr(query + 1);
  while (!rest.empty()) {
    const std::string_view part = rest.substr(0, rest.find('&'));
    if (part.starts_with(kTokenKey)) return part.substr(kTokenKey.size());
    rest.remove_prefix(std::min(rest.size(), part.size() + 1));
  }
  return {};
}

/// Takes the same time wherever the texts differ, so that timing does not reveal the token.
bool is_token(std::string_view given, std::string_view token) {
  unsigned difference = given.size() == token.size() ? 0 : 1;
  for (std::size_t i = 0; i < token.size(); ++i) {
    const char c = i < given.size() ? given[i] : '\0';
    difference |= static_cast<unsigned char>(c) ^ static_cast<unsigned char>(token[i]);
  }
  return difference == 0;
}

std::string_view known_subprotocol(std::string_view offered) {
  while (!offered.empty()) {
    const std::string_view part = offered.substr(0, offered.find(','));
    const std::string_view name = trimmed(part);
    if (std::ranges::find(kSubprotocols, name) != kSubprotocols.end()) return name;
    offered.remove_prefix(std::min(offered.size(), part.size() + 1));
  }
  return {};
}

Admission refused(unsigned status, Refusal refusal, std::string reason) {
  return {.status = status, .refusal = refusal, .reason = std::move(reason)};
}

}  // namespace

std::string_view to_string(Refusal refusal) noexcept {
  static constexpr std::array<std::string_view, kRefusals> kNames{"host", "origin", "token",
                                                                  "subprotocol", "clients"};
  const auto place = static_cast<std::size_t>(refusal);
  ensure(place < kNames.size(), "every refusal has a name");
  return kNames[place];
}

bool is_own_host(std::string_view host, const AdmissionRules& rules) {
  const std::string_view name = name_of(host);
  if (is_address(name) || is_same_text(name, "localhost")) return true;
  return std::ranges::any_of(rules.hosts, [&](const std::string& own) {
    return is_same_text(own, name);
  });
}

Admission admit(const UpgradeRequest& request, const AdmissionRules& rules) {
  constexpr unsigned kBadRequest = 400;
  constexpr unsigned kUnauthorized = 401;
  constexpr unsigned kForbidden = 403;
  if (!is_own_host(request.host, rules)) {
    return refused(
        kForbidden, Refusal::host,
        "the host " + in_quotes(request.host) + " is not a name of this gateway: see --host");
  }
  if (!request.origin.empty() && !is_own_origin(request, rules)) {
    return refused(kForbidden, Refusal::origin,
                   "the origin " + in_quotes(request.origin) + " may not connect: see --origin");
  }
  if (!rules.token.empty() && !is_token(token_of(request), rules.token)) {
    return refused(kUnauthorized, Refusal::token,
                   "the token is missing or wrong: connect with ?token=...");
  }
  // Last, so that clients without access learn nothing about the gateway's protocols.
  const std::string_view subprotocol = known_subprotocol(request.protocols);
  if (subprotocol.empty()) {
    return refused(kBadRequest, Refusal::subprotocol,
                   "the offered sub-protocols " + in_quotes(request.protocols) +
                       " contain neither foxglove.sdk.v1 nor foxglove.websocket.v1");
  }
  return {.status = 101, .subprotocol = std::string(subprotocol)};
}

}  // namespace vdrive::gateway

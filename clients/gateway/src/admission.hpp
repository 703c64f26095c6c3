// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::gateway {

/// Why a request to open a WebSocket is refused.
enum class Refusal : std::uint8_t {
  host,         ///< its host is not a name of the gateway
  origin,       ///< a foreign page
  token,        ///< missing or wrong
  subprotocol,  ///< it offers none that the gateway supports
  clients,      ///< as many clients are connected as may be
};

inline constexpr std::size_t kRefusals = 5;

/// @return such as "origin".
[[nodiscard]] std::string_view to_string(Refusal refusal) noexcept;

/// Who may connect.
struct AdmissionRules {
  std::vector<std::string> hosts{};    ///< names of this machine besides localhost and addresses
  std::vector<std::string> origins{};  ///< foreign pages that may connect, such as "https://x.org"
  std::string token{};                 ///< empty = none needed
};

/// The HTTP request by which a client opens a WebSocket. Empty = not given.
struct UpgradeRequest {
  std::string_view target;         ///< such as "/?token=..."
  std::string_view host;           ///< header Host
  std::string_view origin;         ///< header Origin, which browsers send
  std::string_view protocols;      ///< header Sec-WebSocket-Protocol
  std::string_view authorization;  ///< header Authorization
};

/// The answer to it.
struct Admission {
  unsigned status = 101;            ///< of HTTP; 101 = admitted
  std::string subprotocol{};        ///< admitted: the first one offered that the gateway supports
  Refusal refusal = Refusal::host;  ///< refused: why
  std::string reason{};             ///< refused: a sentence
};

/// A foreign page can lead a browser here under a name of its own (DNS rebinding). An address, and
/// a name that this machine is known to have, are safe.
/// @param host header of an HTTP request
[[nodiscard]] bool is_own_host(std::string_view host, const AdmissionRules& rules);

/// Judges a request to open a WebSocket.
[[nodiscard]] Admission admit(const UpgradeRequest& request, const AdmissionRules& rules);

}  // namespace vdrive::gateway

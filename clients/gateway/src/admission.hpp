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
  host,         ///< the host is not a name of the gateway
  origin,       ///< a foreign page
  token,        ///< missing or wrong
  subprotocol,  ///< none of those offered is supported
  clients,      ///< too many are connected
};

inline constexpr std::size_t kRefusals = 5;

/// @return such as "origin".
[[nodiscard]] std::string_view to_string(Refusal refusal) noexcept;

/// Rules for admitting connections.
struct AdmissionRules {
  std::vector<std::string> hosts{};    ///< names of this machine, in addition to localhost and
                                       ///< addresses
  std::vector<std::string> origins{};  ///< foreign pages that may connect, such as "https://x.org"
  std::string token{};                 ///< empty = not required
};

/// The HTTP request of a client to open a WebSocket. Empty = not given.
struct UpgradeRequest {
  std::string_view target;         ///< such as "/?token=..."
  std::string_view host;           ///< header Host
  std::string_view origin;         ///< header Origin, which browsers send
  std::string_view protocols;      ///< header Sec-WebSocket-Protocol
  std::string_view authorization;  ///< header Authorization
};

/// The answer to an UpgradeRequest.
struct Admission {
  unsigned status = 101;            ///< HTTP status; 101 = admitted
  std::string subprotocol{};        ///< if admitted: first one offered that the gateway supports
  Refusal refusal = Refusal::host;  ///< reason, if refused
  std::string reason{};             ///< sentence, if refused
};

/// @param host header of an HTTP request
/// @return whether it is an address or a known name of this machine. Any other name may belong to a
///         foreign page that leads a browser here (DNS rebinding).
[[nodiscard]] bool is_own_host(std::string_view host, const AdmissionRules& rules);

/// Decides on a request to open a WebSocket.
[[nodiscard]] Admission admit(const UpgradeRequest& request, const AdmissionRules& rules);

}  // namespace vdrive::gateway

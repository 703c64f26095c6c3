// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "protocol.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::gateway {

/// The right that a client needs in order to call a service.
enum class Right : std::uint8_t {
  none,             ///< nothing
  events,           ///< as `none`; answered by EventLog
  judge,            ///< as `none`; answered by JudgeDesk
  stop,             ///< commanding is enabled in the gateway
  command,          ///< this connection has taken control
  jog,              ///< as `command`; carried out by Jogs
  take_control,     ///< as `stop`; carried out by ControlDesk
  release_control,  ///< as `stop`; carried out by ControlDesk
};

/// The answer to a call, as returned by the client library.
struct CallAnswer {
  client::Outcome outcome{};
  Json fields = Json::object();  ///< in addition to those of the outcome
};

/// The action of a service whose only arguments are axes.
struct AxesService {
  /// Commands all axes of one bench together, or none of them. Nothing = `each` is used.
  std::optional<client::EachCommand> command{};
  client::Until until = client::Until::done;
  client::Outcome (client::Axis::*each)() = nullptr;  ///< commands one axis after the other
};

/// A service: a row of the table used by clients, the hub and the documents.
struct ServiceRow {
  std::string_view name;  ///< such as "/move"
  std::string_view type;  ///< such as "vdrive.Move"
  Right right;
  std::string_view request;  ///< members, in the format of object_schema()
  /// Carries out the call and waits until the drive has acted on it. If both this and `axes` are
  /// null, another part carries out the call.
  /// @throws ProtocolError when the request is wrong; says what is wrong and where.
  CallAnswer (*call)(client::Session& session, const Json& request) = nullptr;
  std::optional<AxesService> axes{};  ///< instead of `call`

  /// @pre no other part carries it out
  [[nodiscard]] CallAnswer carry_out(client::Session& session, const Json& asked) const;
};

/// Every service. Its number in the protocol is its index here, counted from 1.
[[nodiscard]] std::span<const ServiceRow> services();

/// @return the announcement of the services to a client.
[[nodiscard]] std::vector<ServiceInfo> service_infos();

/// @return the answer as the response of a service.
[[nodiscard]] std::string answer_text(const CallAnswer& answer);

/// @return the member `key` of a request, false if absent.
/// @throws ProtocolError if it is neither true nor false.
[[nodiscard]] bool flag_of(const Json& request, const char* key);

/// The allowed range of an integer in a request, both ends included.
struct NumberRange {
  std::int64_t lowest = 0;
  std::int64_t highest = 0;
};

/// @return the member `key` of a request, rounded to an integer; nothing if absent.
/// @throws ProtocolError if the member is not a number or out of range; the message names value and
///         range.
[[nodiscard]] std::optional<std::int64_t> optional_integer(const Json& request, const char* key,
                                                           const NumberRange& range);

/// A call of /jog.
struct JogRequest {
  std::string axis;           ///< address or name
  std::int32_t velocity = 0;  ///< [UU/s]; 0 = the button was released
};

/// @throws ProtocolError when the request is wrong.
[[nodiscard]] JogRequest jog_of(const Json& request);

/// The options for calling client::Axis::jog.
[[nodiscard]] client::VelocityOptions jog_options();

}  // namespace vdrive::gateway

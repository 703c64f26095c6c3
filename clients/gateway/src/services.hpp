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

/// What a client must have to call a service.
enum class Right : std::uint8_t {
  none,             ///< nothing
  events,           ///< as `none`; the EventLog answers
  judge,            ///< as `none`; the JudgeDesk answers
  stop,             ///< a gateway that lets clients command
  command,          ///< control, taken by this connection
  jog,              ///< as `command`; Jogs carries it out
  take_control,     ///< as `stop`; the ControlDesk carries it out
  release_control,  ///< as `stop`; the ControlDesk carries it out
};

/// The answer to a call, in the words of the client library.
struct CallAnswer {
  client::Outcome outcome{};
  Json fields = Json::object();  ///< beside those of the outcome
};

/// What axes get by a service that names them and nothing else.
struct AxesService {
  /// What the axes of one bench take together, or none of them; none = `each`.
  std::optional<client::EachCommand> command{};
  client::Until until = client::Until::done;
  client::Outcome (client::Axis::*each)() = nullptr;  ///< for one after the other
};

/// A service: a row of the table that clients, the hub and the documents read.
struct ServiceRow {
  std::string_view name;  ///< such as "/move"
  std::string_view type;  ///< such as "vdrive.Move"
  Right right;
  std::string_view request;  ///< its members, as object_schema() reads them
  /// Carries it out and waits until the drive has acted on it. Null without `axes`: another part
  /// does.
  /// @throws ProtocolError when the request is wrong, with what and where.
  CallAnswer (*call)(client::Session& session, const Json& request) = nullptr;
  std::optional<AxesService> axes{};  ///< in the place of `call`

  /// Not where another part carries it out.
  [[nodiscard]] CallAnswer carry_out(client::Session& session, const Json& asked) const;
};

/// Every service; its number in the protocol is its place here, from 1 on.
[[nodiscard]] std::span<const ServiceRow> services();

/// @return the announcement of the services to a client.
[[nodiscard]] std::vector<ServiceInfo> service_infos();

/// @return the answer as the response of a service.
[[nodiscard]] std::string answer_text(const CallAnswer& answer);

/// @return the member `key` of a request, false without it.
/// @throws ProtocolError when it is neither true nor false.
[[nodiscard]] bool flag_of(const Json& request, const char* key);

/// What a whole number in a request may be, both ends included.
struct NumberRange {
  std::int64_t lowest = 0;
  std::int64_t highest = 0;
};

/// @return the member `key` of a request, rounded to a whole number; nothing without it.
/// @throws ProtocolError when the member is not a number or lies outside the range; the message
///         names value and range.
[[nodiscard]] std::optional<std::int64_t> optional_integer(const Json& request, const char* key,
                                                           const NumberRange& range);

/// A call of /jog.
struct JogRequest {
  std::string axis;           ///< address or name
  std::int32_t velocity = 0;  ///< [UU/s]; 0 = the button was let go
};

/// @throws ProtocolError when the request is wrong.
[[nodiscard]] JogRequest jog_of(const Json& request);

/// How client::Axis::jog is called.
[[nodiscard]] client::VelocityOptions jog_options();

}  // namespace vdrive::gateway

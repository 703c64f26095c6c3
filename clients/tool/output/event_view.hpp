// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "terminal/terminal.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// The events to show, and the form of output.
struct EventChoice {
  std::optional<std::uint32_t> bench;  ///< none = all benches
  std::optional<client::AxisId> axis;  ///< only events of this axis
  bool follow = false;                 ///< until interrupted, otherwise only those that the benches
                                       ///< keep
  bool is_json = false;
};

/// Prints the events that the benches keep, oldest first, then new ones as they arrive.
client::Outcome show_events(client::Session& session, const EventChoice& choice,
                            Terminal& terminal);

/// Waits until no event has arrived for half a second, because nothing marks the end of those that
/// the benches keep. Replaces the observer of Session::on_event.
/// @return the events kept by all benches, by tick; fewer after an interrupt.
[[nodiscard]] std::vector<client::Event> kept_events(client::Session& session);

/// @return the tick of the newest event of this fault, none if the bench does not keep it.
[[nodiscard]] std::optional<std::uint64_t> tick_of_fault(const std::vector<client::Event>& events,
                                                         const client::AxisId& axis,
                                                         std::uint16_t code);

/// @return the name of a session, nothing if unknown.
using SessionNameOf =
    std::function<std::optional<client::SessionName>(std::uint32_t bench, std::uint64_t session)>;

/// @return an event as one line of text; the number of a session is preceded by its program, if
///         known.
[[nodiscard]] std::string event_text(const client::Event& event, const SessionNameOf& name_of);

}  // namespace vdrive::tool

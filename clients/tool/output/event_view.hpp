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

/// Which events are shown, and how.
struct EventChoice {
  std::optional<std::uint32_t> bench;  ///< none = all benches
  std::optional<client::AxisId> axis;  ///< only those of this axis
  bool follow = false;                 ///< until interrupted, else only what the benches keep
  bool is_json = false;
};

/// Prints the events that the benches keep, oldest first, then those that come.
client::Outcome show_events(client::Session& session, const EventChoice& choice,
                            Terminal& terminal);

/// Waits until nothing has come for half a second: nothing marks the end of what the benches keep.
/// Replaces the observer of Session::on_event.
/// @return the events that all benches keep, by tick; fewer after an interrupt.
[[nodiscard]] std::vector<client::Event> kept_events(client::Session& session);

/// @return the tick of the newest event of this fault, none where the bench does not keep it.
[[nodiscard]] std::optional<std::uint64_t> tick_of_fault(const std::vector<client::Event>& events,
                                                         const client::AxisId& axis,
                                                         std::uint16_t code);

/// @return who a session is, nothing where that is not known.
using SessionNameOf =
    std::function<std::optional<client::SessionName>(std::uint32_t bench, std::uint64_t session)>;

/// @return an event as one line of text: before the number of a session the program, where it is
///         known.
[[nodiscard]] std::string event_text(const client::Event& event, const SessionNameOf& name_of);

}  // namespace vdrive::tool

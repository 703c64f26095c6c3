// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive_messages_description.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <type_traits>

/// The kinds of request, one row each: the members a kind uses, who may make it and when. Services
/// refuse by these rows, clients make requests from them, and docs/reference/wire.md is checked
/// against them.
namespace vdrive::wire {

/// Members of a request, as a set.
class RequestMembers {
 public:
  template <typename... Values>
  constexpr explicit RequestMembers(Values msg::Request::*... members) noexcept
      : bits_((0U | ... | bit_of(members))) {}

  [[nodiscard]] constexpr bool contains(RequestMembers others) const noexcept {
    return (others.bits_ & ~bits_) == 0;
  }

 private:
  template <typename Value>
  static constexpr std::uint32_t bit_of(Value msg::Request::*pointer) noexcept {
    std::uint32_t bit = 1;
    std::uint32_t found = 0;
    for_each_member<msg::Request>([&](const auto& member) {
      if constexpr (std::is_same_v<decltype(member.pointer), Value msg::Request::*>) {
        if (member.pointer == pointer) found = bit;
      }
      bit <<= 1U;
    });
    return found;
  }

  std::uint32_t bits_;
};

/// The callers that may make a request.
enum class RequestCaller : std::uint8_t {
  anybody,  ///< even without a session
  session,  ///< any session; 0 is refused with REASON_BAD_SESSION
  owner,    ///< the owner of the axes concerned, or anybody if they are free: depends on the state
  stepper,  ///< a stepper of the clock, or a session that may become one: depends on the state
};

/// When a request may be made.
enum class RequestClock : std::uint8_t {
  any,
  lockstep,  ///< REASON_WRONG_CLOCK_MODE in another mode
  realtime,  ///< likewise
  standing,  ///< lock-step, or paused; otherwise REASON_TIME_PASSES
};

/// A kind of request.
struct RequestKindRow {
  msg::RequestKind kind{};
  /// The members that this kind uses in addition to those that every request has. Others are
  /// ignored, except `session`: in every request it is a sign of life, and it identifies the sender
  /// in events.
  RequestMembers uses;
  RequestCaller caller = RequestCaller::anybody;
  RequestClock clock = RequestClock::any;
};

/// In the order of the IDL.
inline constexpr std::array kRequestKinds = [] {
  using Row = RequestKindRow;
  using Kind = msg::RequestKind;
  using Uses = RequestMembers;
  using Asked = msg::Request;
  using By = RequestCaller;
  using At = RequestClock;
  return std::array{
      Row{Kind::read, Uses{&Asked::objects}},
      Row{Kind::write, Uses{&Asked::session, &Asked::objects}, By::owner},
      Row{Kind::store, Uses{&Asked::session, &Asked::axes}, By::owner},
      Row{Kind::restore, Uses{&Asked::session, &Asked::axes}, By::owner},
      Row{Kind::acquire, Uses{&Asked::session, &Asked::axes}, By::session},
      Row{Kind::take_over, Uses{&Asked::session, &Asked::axes}, By::session},
      Row{Kind::release, Uses{&Asked::session, &Asked::axes}, By::session},
      Row{Kind::power_cycle, Uses{&Asked::session, &Asked::axes}, By::owner},
      Row{Kind::step, Uses{&Asked::session, &Asked::ticks, &Asked::last_sequence, &Asked::axes},
          By::stepper, At::lockstep},
      Row{Kind::set_rate, Uses{&Asked::rate}, By::anybody, At::realtime},
      Row{Kind::join_clock, Uses{&Asked::session, &Asked::ticks}, By::stepper, At::lockstep},
      Row{Kind::leave_clock, Uses{&Asked::session}, By::stepper, At::lockstep},
      Row{Kind::take_snapshot, Uses{}, By::anybody, At::standing},
      Row{Kind::restore_snapshot, Uses{&Asked::session, &Asked::snapshot}, By::owner, At::standing},
      Row{Kind::drop_snapshot, Uses{&Asked::snapshot}, By::anybody, At::standing},
      Row{Kind::next_snapshot, Uses{&Asked::snapshot}},
      Row{Kind::read_writes, Uses{&Asked::snapshot}},
      Row{Kind::freeze_window, Uses{&Asked::session}},
      Row{Kind::next_window, Uses{&Asked::snapshot}},
      Row{Kind::read_window, Uses{&Asked::ticks, &Asked::snapshot, &Asked::axes}},
  };
}();

static_assert(std::ranges::equal(kRequestKinds, Description<msg::RequestKind>::kValues,
                                 [](const RequestKindRow& row, const EnumerationValue& value) {
                                   return static_cast<std::uint32_t>(row.kind) == value.number;
                                 }),
              "each kind of the IDL has a row, in the same order");

static_assert(std::ranges::all_of(kRequestKinds,
                                  [](const RequestKindRow& row) {
                                    return row.caller != RequestCaller::session ||
                                           row.uses.contains(
                                               RequestMembers(&msg::Request::session));
                                  }),
              "a kind that needs a session uses it");

/// @return the row of a kind; nullptr for an unknown number.
[[nodiscard]] constexpr const RequestKindRow* request_kind_row(msg::RequestKind kind) noexcept {
  const auto row = std::ranges::find(kRequestKinds, kind, &RequestKindRow::kind);
  return row == kRequestKinds.end() ? nullptr : &*row;
}

}  // namespace vdrive::wire

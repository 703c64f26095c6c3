// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"
#include "vdrive/wire/request_kinds.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>
#include <utility>
#include <vector>

/// One function per kind of request; each returns the request as a message. Exchange fills in the
/// sender and the receiver.
namespace vdrive::ask {

/// A request with these members. Compiles only if the row of this kind names all of them.
template <msg::RequestKind kKind, auto... kMembers, typename... Values>
msg::Request request(Values&&... values) {
  static_assert(wire::request_kind_row(kKind)->uses.contains(wire::RequestMembers(kMembers...)),
                "the row of the kind does not name the member");
  msg::Request request;
  request.kind = kKind;
  ((request.*kMembers = std::forward<Values>(values)), ...);
  return request;
}

using Axes = std::vector<std::uint16_t>;
using Objects = std::vector<msg::ObjectAccess>;

/// One object of a read or a write.
inline msg::ObjectAccess object(std::uint16_t axis, ObjectAddress address, std::int64_t value = 0) {
  msg::ObjectAccess access;
  access.axis = axis;
  access.index = address.index;
  access.subindex = address.subindex;
  access.value = value;
  return access;
}

inline msg::Request read(Objects objects) {
  return request<msg::RequestKind::read, &msg::Request::objects>(std::move(objects));
}

inline msg::Request write(Objects objects) {
  return request<msg::RequestKind::write, &msg::Request::objects>(std::move(objects));
}

inline msg::Request store(Axes axes) {
  return request<msg::RequestKind::store, &msg::Request::axes>(std::move(axes));
}

inline msg::Request restore(Axes axes) {
  return request<msg::RequestKind::restore, &msg::Request::axes>(std::move(axes));
}

inline msg::Request acquire(Axes axes) {
  return request<msg::RequestKind::acquire, &msg::Request::axes>(std::move(axes));
}

inline msg::Request take_over(Axes axes) {
  return request<msg::RequestKind::take_over, &msg::Request::axes>(std::move(axes));
}

/// @param axes none = all
inline msg::Request release(Axes axes) {
  return request<msg::RequestKind::release, &msg::Request::axes>(std::move(axes));
}

inline msg::Request power_cycle(Axes axes) {
  return request<msg::RequestKind::power_cycle, &msg::Request::axes>(std::move(axes));
}

/// @param shown axes whose status the reply must contain
/// @param last_sequence number of the last command frame that must have arrived before the step
inline msg::Request step(std::uint64_t ticks, Axes shown, std::uint64_t last_sequence = 0) {
  return request<msg::RequestKind::step, &msg::Request::ticks, &msg::Request::axes,
                 &msg::Request::last_sequence>(ticks, std::move(shown), last_sequence);
}

/// @param rate drive time over wall time; 0 = pause
inline msg::Request set_rate(double rate) {
  return request<msg::RequestKind::set_rate, &msg::Request::rate>(rate);
}

/// @param steppers number of steppers that time waits for, including this one
inline msg::Request join_clock(std::uint64_t steppers) {
  return request<msg::RequestKind::join_clock, &msg::Request::ticks>(steppers);
}

inline msg::Request leave_clock() {
  return request<msg::RequestKind::leave_clock>();
}

inline msg::Request take_snapshot() {
  return request<msg::RequestKind::take_snapshot>();
}

inline msg::Request restore_snapshot(std::uint64_t snapshot) {
  return request<msg::RequestKind::restore_snapshot, &msg::Request::snapshot>(snapshot);
}

inline msg::Request drop_snapshot(std::uint64_t snapshot) {
  return request<msg::RequestKind::drop_snapshot, &msg::Request::snapshot>(snapshot);
}

/// @param snapshot the previous one; 0 = none
inline msg::Request next_snapshot(std::uint64_t snapshot) {
  return request<msg::RequestKind::next_snapshot, &msg::Request::snapshot>(snapshot);
}

/// @param place of the last write already read; 0 = none
inline msg::Request read_writes(std::uint64_t place) {
  return request<msg::RequestKind::read_writes, &msg::Request::snapshot>(place);
}

inline msg::Request freeze_window() {
  return request<msg::RequestKind::freeze_window>();
}

/// @param number of the previous one; 0 = none
inline msg::Request next_window(std::uint64_t number) {
  return request<msg::RequestKind::next_window, &msg::Request::snapshot>(number);
}

/// @param place where the page begins, as the previous page returned it; 0 = the beginning
inline msg::Request read_window(std::uint64_t number, Axes axes, std::uint64_t place) {
  return request<msg::RequestKind::read_window, &msg::Request::snapshot, &msg::Request::axes,
                 &msg::Request::ticks>(number, std::move(axes), place);
}

}  // namespace vdrive::ask

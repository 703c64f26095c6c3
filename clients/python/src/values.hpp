// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/unit.hpp"

#include <vector>

/// The values that a program reads, as tuples of plain values: the arguments of the classes in
/// vdrive/_values.py, in their order, and the state of a Status. Call with the interpreter lock.
namespace vdrive::python {

[[nodiscard]] py::tuple tuple_of(const Unit& unit);
[[nodiscard]] py::tuple tuple_of(const client::AxisSnapshot& axis);
[[nodiscard]] py::tuple tuple_of(const client::Event& event);
[[nodiscard]] py::tuple tuple_of(const client::ServiceChange& change);
[[nodiscard]] py::tuple tuple_of(const client::Lateness& lateness);

template <typename Value>
[[nodiscard]] py::list tuples_of(const std::vector<Value>& values) {
  py::list tuples;
  for (const Value& value : values) tuples.append(tuple_of(value));
  return tuples;
}

}  // namespace vdrive::python

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"
#include "vdrive/dictionary/object.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::gateway {

/// A bench and the names that it has in topics and parameters.
struct KnownBench {
  client::BenchInfo info;
  std::string topic;                    ///< such as "bench1"
  std::vector<std::string> axis_names;  ///< in the order of info.axes; each once
};

/// The benches that the gateway has found, by number. It is never changed: a bench that comes or
/// goes makes a new list.
using BenchList = std::shared_ptr<const std::vector<KnownBench>>;

/// @return whether both have the same axes, names, units and period, so that the topics of one are
///         those of the other.
[[nodiscard]] bool have_same_topics(const client::BenchInfo& a, const client::BenchInfo& b);

/// @return the bench with names of its axes: letters, digits and _; where two axes would have one
///         name, the second one's has its number too.
[[nodiscard]] KnownBench known_bench(client::BenchInfo info);

/// An object of an axis, as a parameter names it.
struct ParameterAddress {
  client::AxisId axis;
  ObjectAddress object;
};

/// @return such as "bench1/x/0x6081" and "bench1/x/0x607D:01".
[[nodiscard]] std::string parameter_name(const KnownBench& bench, std::size_t axis,
                                         ObjectAddress object);

/// @return the address of a parameter, or nothing when there is no such bench, axis or object.
[[nodiscard]] std::optional<ParameterAddress> find_parameter(const std::vector<KnownBench>& benches,
                                                             std::string_view name);

/// @return how parameters and services name an object, such as "0x6081" and "0x607D:01".
[[nodiscard]] std::string object_key(ObjectAddress object);

}  // namespace vdrive::gateway

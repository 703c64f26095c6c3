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

/// A bench with its names in topics and parameters.
struct KnownBench {
  client::BenchInfo info;
  std::string topic;                    ///< such as "bench1"
  std::vector<std::string> axis_names;  ///< in the order of info.axes; unique
};

/// The benches found by the gateway, by number. A list never changes: when a bench appears or
/// disappears, a new list is made.
using BenchList = std::shared_ptr<const std::vector<KnownBench>>;

/// @return whether both have the same axes, names, units and period, so that their topics are the
///         same.
[[nodiscard]] bool have_same_topics(const client::BenchInfo& a, const client::BenchInfo& b);

/// @return the bench with the names of its axes, made of letters, digits and _. If two axes have
///         the same name, the number of the second one is appended to its name.
[[nodiscard]] KnownBench known_bench(client::BenchInfo info);

/// The object of an axis that a parameter name refers to.
struct ParameterAddress {
  client::AxisId axis;
  ObjectAddress object;
};

/// @return such as "bench1/x/0x6081" and "bench1/x/0x607D:01".
[[nodiscard]] std::string parameter_name(const KnownBench& bench, std::size_t axis,
                                         ObjectAddress object);

/// @return the address of a parameter, or nothing if the bench, axis or object does not exist.
[[nodiscard]] std::optional<ParameterAddress> find_parameter(const std::vector<KnownBench>& benches,
                                                             std::string_view name);

/// @return the name of an object in parameters and services, such as "0x6081" and "0x607D:01".
[[nodiscard]] std::string object_key(ObjectAddress object);

}  // namespace vdrive::gateway

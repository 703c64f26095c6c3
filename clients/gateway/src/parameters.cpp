// SPDX-License-Identifier: Apache-2.0
#include "parameters.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/text.hpp"

#include <map>

namespace vdrive::gateway {
namespace {

/// What is to be read from one axis, and where its values go.
struct Wanted {
  std::vector<ObjectAddress> objects;
  std::vector<std::size_t> places;
};

void read_axis(client::Session& session, const client::AxisId& id, const Wanted& wanted,
               ParameterAnswer& answer) {
  const auto axis = session.axis(to_string(id));
  if (!axis) {
    answer.complaints.push_back(axis.outcome().message());
    return;
  }
  const auto readings = axis->read(wanted.objects);
  if (!readings) {
    answer.complaints.push_back(readings.outcome().message());
    return;
  }
  ensure(readings->objects.size() == wanted.places.size(),
         "each object that is read has a reading");
  for (std::size_t i = 0; i < wanted.places.size(); ++i) {
    const client::ObjectReading& reading = readings->objects[i];
    if (reading.code == AbortCode::none) answer.parameters[wanted.places[i]].value = reading.value;
  }
}

std::string unknown_text(const std::string& name) {
  return "the parameter " + in_quotes(name) + " does not exist" +
         R"(: expected such as "bench1/x/0x6081" or "bench1/x/0x607D:01")";
}

}  // namespace

std::vector<std::string> all_parameters(const std::vector<KnownBench>& benches) {
  std::size_t axes = 0;
  for (const KnownBench& bench : benches) axes += bench.axis_names.size();
  std::vector<std::string> names;
  if (axes > kMostAxesOfAll) return names;
  names.reserve(axes * kObjectTable.size());
  for (const KnownBench& bench : benches) {
    for (std::size_t axis = 0; axis < bench.axis_names.size(); ++axis) {
      for (const ObjectDescription& row : kObjectTable) {
        names.push_back(parameter_name(bench, axis, row.address));
      }
    }
  }
  return names;
}

ParameterAnswer read_parameters(client::Session& session, const std::vector<KnownBench>& benches,
                                const std::vector<std::string>& names) {
  ParameterAnswer answer;
  std::map<client::AxisId, Wanted> axes;  // one request an axis, so that its values are of one tick
  answer.parameters.reserve(names.size());
  for (const std::string& name : names) {
    const auto address = find_parameter(benches, name);
    if (!address) {
      answer.complaints.push_back(unknown_text(name));
      continue;
    }
    Wanted& wanted = axes[address->axis];
    wanted.objects.push_back(address->object);
    wanted.places.push_back(answer.parameters.size());
    answer.parameters.push_back({.name = name, .value = {}});
  }
  for (const auto& [id, wanted] : axes) read_axis(session, id, wanted, answer);
  return answer;
}

ParameterAnswer write_parameters(client::Session& session, const std::vector<KnownBench>& benches,
                                 const std::vector<ParameterChange>& changes) {
  std::vector<std::string> complaints;
  std::vector<std::string> names;
  names.reserve(changes.size());
  // In the order of the request: a later value may depend on an earlier one.
  for (const ParameterChange& change : changes) {
    const auto address = find_parameter(benches, change.name);
    if (!address) {
      complaints.push_back(unknown_text(change.name));
      continue;
    }
    names.push_back(change.name);
    auto axis = session.axis(to_string(address->axis));
    const client::Outcome outcome =
        axis ? axis->write(address->object, change.value).outcome() : axis.outcome();
    if (!outcome) {
      complaints.push_back(change.name + " = " + std::to_string(change.value) + ": " +
                           outcome.message());
    }
  }
  // What the drive made of it, also where it refused: a client shows the value in force.
  ParameterAnswer answer = read_parameters(session, benches, names);
  answer.complaints.insert(answer.complaints.begin(), complaints.begin(), complaints.end());
  return answer;
}

}  // namespace vdrive::gateway

// SPDX-License-Identifier: Apache-2.0
#include "parameter_desk.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/text.hpp"

#include <map>
#include <utility>

namespace vdrive::gateway {
namespace {

/// The objects to read from one axis, and the positions of their values in the answer.
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
         R"(: write it like "bench1/x/0x6081" or "bench1/x/0x607D:01")";
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
  std::map<client::AxisId, Wanted> axes;  // one request per axis, so that its values belong to one
                                          // tick
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
  // In the order of the request, because a later value may depend on an earlier one.
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
  // Reads the values back, even after refused writes: a client shows the value in force.
  ParameterAnswer answer = read_parameters(session, benches, names);
  answer.complaints.insert(answer.complaints.begin(), complaints.begin(), complaints.end());
  return answer;
}

// ---- the desk

template <typename Call>
void ParameterDesk::post(ConnectionId id, const std::optional<std::string>& request, Call call) {
  const bool is_posted = clients_.post(id, [this, id, request, call = std::move(call)] {
    server_.post([this, id, request, answer = call()] {
      send(id, answer, request);
    });
  });
  if (!is_posted) {
    server_.send_status(id, Level::error, "too many requests are waiting: this one was dropped");
  }
}

void ParameterDesk::get(ConnectionId id, const GetParameters& message, const BenchList& benches) {
  std::vector<std::string> names = message.names;
  if (names.empty()) names = all_parameters(*benches);
  if (names.empty() && !benches->empty()) {
    server_.send_status(id, Level::warning,
                        "the benches have more than " + std::to_string(kMostAxesOfAll) +
                            R"( axes: ask for parameters by name, such as "bench1/x/0x6081")");
  }
  post(id, message.id, [this, benches, names = std::move(names)] {
    return access_.read(benches, names);
  });
}

void ParameterDesk::set(ConnectionId id, const SetParameters& message, const BenchList& benches) {
  if (const client::Outcome right = control_.check(id, Right::command); !right) {
    return server_.send_status(id, Level::error, right.message());
  }
  post(id, message.id,
       [this, own = control_.session_of(id), benches, changes = message.parameters] {
         return access_.write(own, benches, changes);
       });
}

void ParameterDesk::send(ConnectionId id, const ParameterAnswer& answer,
                         const std::optional<std::string>& request) const {
  if (!clients_.contains(id)) return;  // closed while its call waited
  for (const std::string& complaint : answer.complaints) {
    server_.send_status(id, Level::error, complaint);
  }
  server_.send_text(id, parameters_text(answer.parameters, request));
}

void ParameterDesk::subscribe(ConnectionId id, const SubscribeParameters& message) {
  Subscribed& subscribed = subscribers_[id];
  for (const std::string& name : message.names) {
    if (!message.is_on) {
      subscribed.values.erase(name);
      subscribed.unsent.erase(name);
      continue;
    }
    if (subscribed.values.size() >= kMost) {
      return server_.send_status(
          id, Level::error,
          "a connection can subscribe to at most " + std::to_string(kMost) + " parameters");
    }
    if (subscribed.values.emplace(name, std::nullopt).second) subscribed.unsent.insert(name);
  }
}

void ParameterDesk::poll(const BenchList& benches) {
  // A slow bench is not asked again before it has answered, so that polls do not queue up.
  if (is_polling_) return;
  std::set<std::string> names;  // each is read once for all clients
  for (const auto& [id, subscribed] : subscribers_) {
    for (const auto& [name, value] : subscribed.values) names.insert(name);
  }
  if (names.empty()) return;
  is_polling_ = polls_.post([this, benches, list = std::vector(names.begin(), names.end())] {
    server_.post([this, answer = access_.read(benches, list)] {
      on_polled(answer);
    });
  });
}

void ParameterDesk::on_polled(const ParameterAnswer& answer) {
  is_polling_ = false;
  for (auto& [id, subscribed] : subscribers_) {
    std::vector<Parameter> changed;
    for (const Parameter& parameter : answer.parameters) {
      const auto known = subscribed.values.find(parameter.name);
      if (known == subscribed.values.end()) continue;
      // The first value is sent even if the drive refuses the read, so that the client need not
      // wait for a change.
      const bool is_first = subscribed.unsent.erase(parameter.name) != 0;
      if (!is_first && known->second == parameter.value) continue;
      known->second = parameter.value;
      changed.push_back(parameter);
    }
    if (!changed.empty()) server_.send_text(id, parameters_text(changed, std::nullopt));
  }
}

}  // namespace vdrive::gateway

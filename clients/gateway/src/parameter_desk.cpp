// SPDX-License-Identifier: Apache-2.0
#include "parameter_desk.hpp"

#include <utility>

namespace vdrive::gateway {

ParameterDesk::ParameterDesk(Calls calls, ServerCalls server, ClientTable& clients,
                             const ControlDesk& control)
    : calls_(std::move(calls)), server_(std::move(server)), clients_(clients), control_(control) {}

void ParameterDesk::get(ConnectionId id, const GetParameters& message, const BenchList& benches) {
  std::vector<std::string> names = message.names;
  if (names.empty()) names = all_parameters(*benches);
  if (names.empty() && !benches->empty()) {
    server_.send_status(id, Level::warning,
                        "the benches have more than " + std::to_string(kMostAxesOfAll) +
                            R"( axes: ask for parameters by name, such as "bench1/x/0x6081")");
  }
  post(id, message.id, [this, benches, names = std::move(names)] {
    return calls_.read(benches, names);
  });
}

void ParameterDesk::set(ConnectionId id, const SetParameters& message, const BenchList& benches) {
  if (const client::Outcome right = control_.check(id, Right::command); !right) {
    return server_.send_status(id, Level::error, right.message());
  }
  post(id, message.id,
       [this, own = control_.session_of(id), benches, changes = message.parameters] {
         return calls_.write(own, benches, changes);
       });
}

void ParameterDesk::post(ConnectionId id, const std::optional<std::string>& request,
                         std::function<ParameterAnswer()> call) {
  const bool is_posted = clients_.post(id, [this, id, request, call = std::move(call)] {
    server_.post([this, id, request, answer = call()] {
      send(id, answer, request);
    });
  });
  if (!is_posted) {
    server_.send_status(id, Level::error, "too many requests wait: this one is dropped");
  }
}

void ParameterDesk::send(ConnectionId id, const ParameterAnswer& answer,
                         const std::optional<std::string>& request) const {
  if (!clients_.contains(id)) return;  // it closed while its call waited
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
          "a connection subscribes " + std::to_string(kMost) + " parameters at most");
    }
    if (subscribed.values.emplace(name, std::nullopt).second) subscribed.unsent.insert(name);
  }
}

void ParameterDesk::poll(const BenchList& benches) {
  // A slow bench is asked again when it has answered: else the polls would queue up.
  if (is_polling_) return;
  std::set<std::string> names;  // each is read once for all clients
  for (const auto& [id, subscribed] : subscribers_) {
    for (const auto& [name, value] : subscribed.values) names.insert(name);
  }
  if (names.empty()) return;
  is_polling_ = polls_.post([this, benches, list = std::vector(names.begin(), names.end())] {
    server_.post([this, answer = calls_.read(benches, list)] {
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
      // The first one also when the drive refuses it: a client must not wait for a change.
      const bool is_first = subscribed.unsent.erase(parameter.name) != 0;
      if (!is_first && known->second == parameter.value) continue;
      known->second = parameter.value;
      changed.push_back(parameter);
    }
    if (!changed.empty()) server_.send_text(id, parameters_text(changed, std::nullopt));
  }
}

}  // namespace vdrive::gateway

// SPDX-License-Identifier: Apache-2.0
#include "parameter_watch.hpp"

#include <utility>
#include <vector>

namespace vdrive::gateway {

bool ParameterWatch::subscribe(ConnectionId id, const SubscribeParameters& message) {
  Subscribed& subscribed = clients_[id];
  for (const std::string& name : message.names) {
    if (!message.is_on) {
      subscribed.values.erase(name);
      subscribed.unsent.erase(name);
      continue;
    }
    if (subscribed.values.size() >= kMost) return false;
    if (subscribed.values.emplace(name, std::nullopt).second) subscribed.unsent.insert(name);
  }
  return true;
}

void ParameterWatch::poll(const BenchList& benches) {
  if (is_polling_) return;
  std::set<std::string> names;
  for (const auto& [id, subscribed] : clients_) {
    for (const auto& [name, value] : subscribed.values) names.insert(name);
  }
  if (names.empty()) return;
  is_polling_ = polls_.post([this, benches, list = std::vector(names.begin(), names.end())] {
    auto answer = read_parameters(session_, *benches, list);
    server_.post([this, answer = std::move(answer)] {
      on_polled(answer);
    });
  });
}

void ParameterWatch::on_polled(const ParameterAnswer& answer) {
  is_polling_ = false;
  for (auto& [id, subscribed] : clients_) {
    std::vector<Parameter> changed;
    for (const Parameter& parameter : answer.parameters) {
      const auto known = subscribed.values.find(parameter.name);
      if (known == subscribed.values.end()) continue;
      const bool is_first = subscribed.unsent.erase(parameter.name) != 0;
      if (!is_first && known->second == parameter.value) continue;
      known->second = parameter.value;
      changed.push_back(parameter);
    }
    if (!changed.empty()) server_.send_answer(id, parameters_text(changed, std::nullopt));
  }
}

}  // namespace vdrive::gateway

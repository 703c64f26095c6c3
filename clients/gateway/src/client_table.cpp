// SPDX-License-Identifier: Apache-2.0
#include "client_table.hpp"

#include "vdrive/assert.hpp"

#include <utility>

namespace vdrive::gateway {
namespace {

template <typename Clients>
auto& client_of(Clients& clients, ConnectionId id) {
  ensure(clients.contains(id), "a connection that is named here is open");
  return clients.at(id);
}

}  // namespace

void ClientTable::open(ConnectionId id) {
  clients_[id] = {.name = "client " + std::to_string(id),
                  .worker = std::make_unique<bridge::Worker>()};
  count_ = clients_.size();
}

bool ClientTable::close(ConnectionId id) {
  const auto closed = clients_.extract(id);
  if (closed.empty()) return false;
  count_ = clients_.size();
  // A call may run for seconds: the server's thread does not wait for it.
  closed.mapped().worker->close();
  ended_.push_back(std::move(closed.mapped().worker));
  return true;
}

const std::string& ClientTable::name(ConnectionId id) const {
  return client_of(clients_, id).name;
}

void ClientTable::rename(ConnectionId id, std::string name) {
  client_of(clients_, id).name = std::move(name);
}

bool ClientTable::post(ConnectionId id, std::function<void()> job) {
  return client_of(clients_, id).worker->post(std::move(job));
}

void ClientTable::forget_ended() {
  std::erase_if(ended_, [](const auto& worker) {
    return worker->has_ended();
  });
}

std::vector<ConnectionId> ClientTable::all() const {
  std::vector<ConnectionId> ids;
  ids.reserve(clients_.size());
  for (const auto& [id, client] : clients_) ids.push_back(id);
  return ids;
}

}  // namespace vdrive::gateway

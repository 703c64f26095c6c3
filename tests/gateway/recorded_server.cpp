// SPDX-License-Identifier: Apache-2.0
#include "recorded_server.hpp"

#include <chrono>
#include <utility>

namespace vdrive::gateway {

void RecordedServer::send_data(ConnectionId id, Frame frame) {
  sent_[id].push_back(std::move(frame));
}

void RecordedServer::send_answer(ConnectionId id, Frame frame, bool /*is_shared*/) {
  sent_[id].push_back(std::move(frame));
}

void RecordedServer::set_patience(ConnectionId id, Patience patience) {
  patience_[id] = patience;
}

void RecordedServer::post(std::function<void()> action) {
  const std::scoped_lock lock(mutex_);
  actions_.push_back(std::move(action));
  posted_.notify_all();
}

std::vector<std::string> RecordedServer::take(ConnectionId id) {
  std::vector<std::string> messages;
  for (const Frame& frame : std::exchange(sent_[id], {})) {
    const std::string head(frame.head.data(), frame.head_size);
    messages.push_back(head + (frame.body ? *frame.body : std::string()));
  }
  return messages;
}

std::vector<Json> RecordedServer::take_json(ConnectionId id) {
  std::vector<Json> messages;
  for (const Frame& frame : std::exchange(sent_[id], {})) {
    // The body of a response begins with its encoding, followed by the JSON text.
    const std::string& body = *frame.body;
    messages.push_back(Json::parse(body.substr(body.find('{')), nullptr, false));
  }
  return messages;
}

bool RecordedServer::run(std::size_t count) {
  for (; count > 0; --count) {
    if (!await()) return false;
    std::unique_lock lock(mutex_);
    const auto action = std::move(actions_.front());
    actions_.pop_front();
    lock.unlock();
    action();
  }
  return true;
}

bool RecordedServer::await() {
  std::unique_lock lock(mutex_);
  return posted_.wait_for(lock, std::chrono::seconds(10), [this] {
    return !actions_.empty();
  });
}

std::size_t RecordedServer::waiting() {
  const std::scoped_lock lock(mutex_);
  return actions_.size();
}

}  // namespace vdrive::gateway

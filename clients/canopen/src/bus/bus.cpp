// SPDX-License-Identifier: Apache-2.0
#include "bus/bus.hpp"

#include <algorithm>

namespace vdrive::canopen {

void Bus::attach(Port& port) {
  ports_.push_back(&port);
}

void Bus::detach(Port& port) {
  // Forgets the sender of waiting frames, because a new port may get the same address.
  for (Waiting& waiting : waiting_) {
    if (waiting.sender == &port) waiting.sender = nullptr;
  }
  release(port);
  const auto found = std::ranges::find(ports_, &port);
  if (found == ports_.end()) return;
  if (is_delivering_) {
    *found = nullptr;  // send() iterates by index
  } else {
    ports_.erase(found);
  }
}

void Bus::hold(const Port& port) {
  if (std::ranges::find(holders_, &port) == holders_.end()) holders_.push_back(&port);
}

void Bus::release(const Port& port) {
  if (std::erase(holders_, &port) == 0 || is_held()) return;
  for (Port* const attached : ports_) {
    if (attached != nullptr) attached->resume();
  }
}

std::uint64_t Bus::send(const Frame& frame, const Port* sender) {
  if (waiting_.size() >= kMostAtOnce) {
    note_dropped(1);
    return 0;
  }
  waiting_.push_back({frame, sender});
  const std::uint64_t number = ++sent_;
  if (!is_delivering_) deliver_waiting();
  return number;
}

void Bus::deliver_waiting() {
  is_delivering_ = true;
  // By index: a delivery may append frames and ports.
  std::size_t next = 0;
  while (next < waiting_.size()) {
    const Waiting sent = waiting_[next++];
    ++frames_;
    // A port attached during a delivery gets only the frames after this one.
    const std::size_t ports = ports_.size();
    for (std::size_t place = 0; place < ports; ++place) {
      Port* const port = ports_[place];
      if (port != nullptr && port != sent.sender) port->deliver(sent.frame);
    }
  }
  is_delivering_ = false;
  waiting_.clear();
  std::erase(ports_, nullptr);
}

}  // namespace vdrive::canopen

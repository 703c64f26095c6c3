// SPDX-License-Identifier: Apache-2.0
#include "owner_log.hpp"

#include <utility>

namespace vdrive::gateway {
namespace {

template <typename Value>
void append(std::deque<Value>& values, Value value) {
  values.push_back(std::move(value));
  if (values.size() > OwnerLog::kMost) values.pop_front();
}

}  // namespace

void OwnerLog::note(const client::Observation& observation) {
  const std::scoped_lock lock(mutex_);
  for (const client::AxisSnapshot& axis : observation.axes) note_session(axis.owner_session);
}

void OwnerLog::note(const client::Event& event) {
  if (event.kind != client::EventKind::control_changed) return;
  const std::scoped_lock lock(mutex_);
  const bool is_loss = event.code == 0;  // otherwise the code is the new epoch of the session that
                                         // gained control
  if (is_loss) {
    append(lost_, {.axis = event.axis, .from = event.session, .by = 0, .tick = event.tick});
    return;
  }
  note_session(event.session);
  std::erase_if(takings_, [&event](const Taking& taking) {
    return taking.from == event.session && (event.axis == 0 || event.axis == taking.axis);
  });
  // A bench reports losses before gains, both in the same tick.
  for (Taking taking : std::exchange(lost_, {})) {
    const bool is_taken = taking.tick == event.tick && taking.axis != 0 &&
                          (event.axis == 0 || event.axis == taking.axis);
    if (!is_taken) continue;
    taking.by = event.session;
    append(takings_, taking);
  }
}

std::vector<std::uint64_t> OwnerLog::sessions() const {
  const std::scoped_lock lock(mutex_);
  return {sessions_.begin(), sessions_.end()};
}

std::vector<Taking> OwnerLog::takings() const {
  const std::scoped_lock lock(mutex_);
  return {takings_.begin(), takings_.end()};
}

void OwnerLog::note_session(std::uint64_t session) {
  const bool is_newest = !sessions_.empty() && sessions_.back() == session;  // the usual case
  if (session == 0 || is_newest) return;
  std::erase(sessions_, session);
  append(sessions_, session);
}

}  // namespace vdrive::gateway

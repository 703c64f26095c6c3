// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/matches.hpp"

#include <algorithm>

namespace vdrive::wire {

void Matches::add(const EndpointId& endpoint) {
  const std::scoped_lock lock(mutex_);
  std::erase(endpoints_, endpoint);  // DDS may report a match twice
  endpoints_.push_back(endpoint);
  changed_.notify_all();
}

void Matches::remove(const EndpointId& endpoint) {
  const std::scoped_lock lock(mutex_);
  std::erase(endpoints_, endpoint);
  changed_.notify_all();
}

std::size_t Matches::count() const {
  const std::scoped_lock lock(mutex_);
  return endpoints_.size();
}

std::vector<Source> Matches::sources() const {
  const std::scoped_lock lock(mutex_);
  std::vector<Source> sources(endpoints_.size());
  std::ranges::transform(endpoints_, sources.begin(), &EndpointId::source);
  return sources;
}

bool Matches::contains(const Source& source) const {
  const std::scoped_lock lock(mutex_);
  return has(source);
}

bool Matches::wait_for(std::size_t count, std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, timeout, [&] {
    return endpoints_.size() >= count;
  });
}

bool Matches::wait_for(const Source& source, std::chrono::milliseconds timeout) {
  // Even a wait of 0 would call the kernel, for each reply without a reader.
  if (timeout <= std::chrono::milliseconds::zero()) return contains(source);
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, timeout, [&] {
    return has(source);
  });
}

bool Matches::has(const Source& source) const {
  return std::ranges::find(endpoints_, source, &EndpointId::source) != endpoints_.end();
}

}  // namespace vdrive::wire

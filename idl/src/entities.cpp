// SPDX-License-Identifier: Apache-2.0
#include "entities.hpp"

#include <algorithm>

namespace vdrive::wire {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

dds::Topic* Participant::Entities::topic(const std::string& name, const dds::TypeSupport& type) {
  const std::lock_guard lock(mutex_);
  if (auto* const known = participant->lookup_topicdescription(name); known != nullptr) {
    return dynamic_cast<dds::Topic*>(known);
  }
  if (participant->register_type(type) != eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
    throw NetworkError("DDS refuses the type of topic " + name);
  }
  auto* const topic = participant->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  if (topic == nullptr) throw NetworkError("DDS refuses the topic " + name);
  return topic;
}

Source source_of(const rtps::InstanceHandle_t& handle) noexcept {
  Source source;
  for (std::size_t byte = 0; byte < source.participant.size(); ++byte) {
    source.participant[byte] = handle.value[byte];
  }
  return source;
}

WriterId writer_of(const rtps::InstanceHandle_t& handle) noexcept {
  WriterId writer{.source = source_of(handle)};
  const std::size_t begin = writer.source.participant.size();
  for (std::size_t byte = 0; byte < writer.entity.size(); ++byte) {
    writer.entity[byte] = handle.value[begin + byte];
  }
  return writer;
}

void Matches::update(const rtps::InstanceHandle_t& endpoint, int change) {
  const std::lock_guard lock(mutex_);
  std::erase(endpoints_, endpoint);
  if (change > 0) endpoints_.push_back(endpoint);
  changed_.notify_all();
}

std::size_t Matches::count() const {
  const std::lock_guard lock(mutex_);
  return endpoints_.size();
}

std::vector<Source> Matches::sources() const {
  const std::lock_guard lock(mutex_);
  std::vector<Source> sources(endpoints_.size());
  std::ranges::transform(endpoints_, sources.begin(), source_of);
  return sources;
}

bool Matches::wait_for(std::size_t count, std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, timeout, [&] {
    return endpoints_.size() >= count;
  });
}

bool Matches::wait_for(const Source& source, std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  if (timeout <= std::chrono::milliseconds::zero()) {
    return contains(source);  // a wait of no time calls the kernel, for each reply without a reader
  }
  return changed_.wait_for(lock, timeout, [&] {
    return contains(source);
  });
}

bool Matches::contains(const Source& source) const {
  return std::ranges::any_of(endpoints_, [&](const auto& endpoint) {
    return source_of(endpoint) == source;
  });
}

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#include "dds/entities.hpp"

namespace vdrive::wire {

dds::Topic* DdsEntities::topic(const std::string& name, const dds::TypeSupport& type) {
  const std::lock_guard lock(mutex_);
  if (auto* const known = participant->lookup_topicdescription(name); known != nullptr) {
    return dynamic_cast<dds::Topic*>(known);
  }
  if (!is_ok(participant->register_type(type))) {
    throw NetworkError("DDS could not register the type of topic " + name);
  }
  auto* const topic = participant->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  if (topic == nullptr) throw NetworkError("DDS could not create the topic " + name);
  return topic;
}

Source source_of(const rtps::InstanceHandle_t& handle) noexcept {
  Source source;
  for (std::size_t byte = 0; byte < source.participant.size(); ++byte) {
    source.participant[byte] = handle.value[byte];
  }
  return source;
}

EndpointId endpoint_of(const rtps::InstanceHandle_t& handle) noexcept {
  EndpointId endpoint{.source = source_of(handle)};
  const std::size_t begin = endpoint.source.participant.size();
  for (std::size_t byte = 0; byte < endpoint.entity.size(); ++byte) {
    endpoint.entity[byte] = handle.value[begin + byte];
  }
  return endpoint;
}

}  // namespace vdrive::wire

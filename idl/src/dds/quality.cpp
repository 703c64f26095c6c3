// SPDX-License-Identifier: Apache-2.0
#include "dds/quality.hpp"

#include <cstdint>

namespace vdrive::wire {
namespace {

// Samples that the library allocates at the start; it allocates more when needed.
constexpr std::int32_t kFirstAllocation = 8;

/// Settings common to writer and reader.
template <typename Qos>
void apply(const TopicTraits& topic, Qos& qos) {
  qos.reliability().kind =
      topic.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = {0, 100'000'000};
  qos.durability().kind =
      topic.transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = topic.keep_all ? dds::KEEP_ALL_HISTORY_QOS : dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = topic.depth;
  qos.resource_limits().max_instances = topic.instances;
  qos.resource_limits().max_samples_per_instance = topic.depth;
  qos.resource_limits().max_samples = topic.depth * topic.instances;
  qos.resource_limits().allocated_samples = kFirstAllocation;
  qos.data_sharing().off();
}

}  // namespace

dds::DataWriterQos writer_qos(const TopicTraits& topic) {
  dds::DataWriterQos qos;
  apply(topic, qos);
  if (topic.writer_keeps_newest) qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  if (!topic.reliable) {
    // No reader can request a sample that has been sent. The next sample reuses its memory, which
    // is still in the processor caches.
    qos.history().depth = 1;
    qos.resource_limits().max_samples_per_instance = 1;
    qos.resource_limits().max_samples = topic.instances;
  }
  qos.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
  qos.writer_data_lifecycle().autodispose_unregistered_instances = false;
  // Each sample takes only the memory that it needs, not the 75 kB of the largest one, and the next
  // reuses it: no allocation in steady state.
  qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  set_times(qos, {.first_heartbeat = {0, 5'000'000},
                  .heartbeat_period = {0, 10'000'000},
                  .nack_response = {0, 1'000'000}});
  return qos;
}

dds::DataReaderQos reader_qos(const TopicTraits& topic) {
  dds::DataReaderQos qos;
  apply(topic, qos);
  // Allocate twice the largest sample of the type and drop larger ones; the other modes allocate
  // whatever size a sender claims. Pages that are never written cost no memory.
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
  set_times(qos, {.first_acknack = {0, 5'000'000}, .heartbeat_response = {0, 1'000'000}});
  return qos;
}

}  // namespace vdrive::wire

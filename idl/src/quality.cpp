// SPDX-License-Identifier: Apache-2.0
#include "quality.hpp"

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdrive::wire {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

constexpr std::int32_t kAxesInDomain = 65'536;
constexpr std::int32_t kBenchesInDomain = 1'024;
constexpr std::int32_t kBenchPartsInDomain = 4'096;
constexpr std::int32_t kFirstAllocation = 8;

constexpr TopicQuality kQueue{.reliable = true, .keep_all = true, .depth = 1'024};

constexpr std::array<std::pair<std::string_view, TopicQuality>, 10> kQualities{{
    {"command", kQueue},
    {"command_reply", kQueue},
    {"request", kQueue},
    {"reply", kQueue},
    {"status", {.depth = 64}},
    {"axis", {.instances = kAxesInDomain}},
    {"parameters", {.reliable = true, .transient_local = true, .instances = kAxesInDomain}},
    {"event",
     {.reliable = true, .transient_local = true, .depth = 1'024, .instances = kBenchesInDomain}},
    {"bench", {.reliable = true, .transient_local = true, .instances = kBenchPartsInDomain}},
    {"bench_state", {.instances = kBenchesInDomain}},
}};

/// What writer and reader have in common.
template <typename Qos>
void apply(const TopicQuality& quality, Qos& qos) {
  qos.reliability().kind =
      quality.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = {0, 100'000'000};
  qos.durability().kind =
      quality.transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = quality.keep_all ? dds::KEEP_ALL_HISTORY_QOS : dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = quality.depth;
  qos.resource_limits().max_instances = quality.instances;
  qos.resource_limits().max_samples_per_instance = quality.depth;
  qos.resource_limits().max_samples = quality.depth * quality.instances;
  qos.resource_limits().allocated_samples = kFirstAllocation;
  qos.data_sharing().off();
}

}  // namespace

TopicQuality quality_of(std::string_view name) {
  for (const auto& [topic, quality] : kQualities) {
    if (topic == name) {
      return quality;
    }
  }
  throw std::logic_error("no quality of service for topic " + std::string(name));
}

dds::DataWriterQos writer_qos(const TopicQuality& quality) {
  dds::DataWriterQos qos;
  apply(quality, qos);
  qos.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
  qos.writer_data_lifecycle().autodispose_unregistered_instances = false;
  // Room for what a sample needs, kept for the next one: no allocation once warm, and none of the
  // 75 kB that the largest sample would take.
  qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  auto& times = qos.reliable_writer_qos().times;
  times.initialHeartbeatDelay = {0, 5'000'000};
  times.heartbeatPeriod = {0, 10'000'000};
  times.nackResponseDelay = {0, 1'000'000};
  return qos;
}

dds::DataReaderQos reader_qos(const TopicQuality& quality) {
  dds::DataReaderQos qos;
  apply(quality, qos);
  // Room for twice the largest sample of the type, and a sample that claims more is dropped: the
  // other modes make as much room as its sender says. The kernel gives the pages that are written
  // to.
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
  auto& times = qos.reliable_reader_qos().times;
  times.initialAcknackDelay = {0, 5'000'000};
  times.heartbeatResponseDelay = {0, 1'000'000};
  return qos;
}

}  // namespace vdrive::wire

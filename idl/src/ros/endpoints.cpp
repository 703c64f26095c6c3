// SPDX-License-Identifier: Apache-2.0
#include "ros/endpoints.hpp"

#include "dds/bytes_type.hpp"
#include "dds/reader.hpp"
#include "dds/writer.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/cdr.hpp"
#include "vdrive/wire/ros.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::ros {
namespace {

namespace dds = wire::dds;
namespace rtps = wire::rtps;

// The usual depth in ROS 2.
constexpr std::int32_t kDepth = 10;
// For /rosout: messages that a node still receives when it joins late.
constexpr std::int32_t kDepthForLate = 100;

/// Settings common to writer and reader.
template <typename Qos>
void apply(std::string_view type, std::int32_t depth, Qos& qos) {
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = depth;
  qos.resource_limits().max_samples = depth;
  qos.resource_limits().allocated_samples = 1;
  qos.data_sharing().off();
  const std::string text = "typehash=" + type_hash(type) + ";";
  qos.user_data().setValue(std::vector<rtps::octet>(text.begin(), text.end()));
}

bool is_part(std::string_view part) {
  return !part.empty() && std::isdigit(static_cast<unsigned char>(part.front())) == 0 &&
         std::ranges::all_of(part, [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '_';
         });
}

}  // namespace

std::string dds_topic(std::string_view name) {
  return "rt" + std::string(name);
}

std::string check_topic(std::string_view name) {
  std::string rule = in_quotes(name) +
                     " is not the name of a topic: it must start with '/'; its parts consist of "
                     "letters, digits and '_' and must not start with a digit";
  if (!name.starts_with('/')) return rule;
  std::string_view rest = name.substr(1);
  while (true) {
    const std::size_t slash = rest.find('/');
    if (!is_part(rest.substr(0, slash))) return rule;
    if (slash == std::string_view::npos) return {};
    rest.remove_prefix(slash + 1);
  }
}

dds::DataWriterQos writer_qos(std::string_view type, const Traits& traits) {
  dds::DataWriterQos qos;
  apply(type, traits.kept_for_late ? kDepthForLate : kDepth, qos);
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = {0, 100'000'000};
  qos.durability().kind =
      traits.kept_for_late ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  // A joining node has been seen to block a synchronous writer for seconds.
  qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
  qos.writer_data_lifecycle().autodispose_unregistered_instances = false;
  qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  return qos;
}

dds::DataReaderQos reader_qos(std::string_view type, const Traits& traits) {
  dds::DataReaderQos qos;
  apply(type, traits.kept_for_late ? kDepthForLate : kDepth, qos);
  qos.reliability().kind =
      traits.takes_any_writer ? dds::BEST_EFFORT_RELIABILITY_QOS : dds::RELIABLE_RELIABILITY_QOS;
  // A reader also wants the samples that the writer has kept from before the reader joined.
  qos.durability().kind =
      traits.kept_for_late ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  // A sample larger than the type allows is dropped. The kernel provides only the pages that are
  // written to.
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
  return qos;
}

namespace {

constexpr std::size_t kLargest = 4U << 20U;  // [bytes] a trajectory of thousands of points

template <typename Message>
dds::TypeSupport type_of() {
  return dds::TypeSupport(
      new wire::BytesType(std::string(wire::Description<Message>::kName), kLargest, nullptr));
}

}  // namespace

template <typename Message>
struct Publication<Message>::Entities {
  wire::DdsWriter writer;
  std::mutex encoding;
  std::vector<std::byte> sample;  ///< the last one
};

template <typename Message>
Publication<Message>::Publication(wire::Participant& participant, std::string_view topic)
    : entities_(new Entities{
          .writer = {wire::dds_entities(participant), dds_topic(topic), type_of<Message>(),
                     writer_qos(ros_name<Message>(), kTraits<Message>)},
          .encoding = {},
          .sample = {}}) {}

template <typename Message>
Publication<Message>::~Publication() = default;

template <typename Message>
bool Publication<Message>::write(const Message& message) noexcept {
  try {
    const std::scoped_lock lock(entities_->encoding);
    wire::write_sample(entities_->sample, [&](wire::CdrWriter& writer) {
      writer.put(message);
    });
    return entities_->writer.write(entities_->sample);
  } catch (...) {  // out of memory
    return false;
  }
}

template <typename Message>
std::size_t Publication<Message>::matched() const noexcept {
  return entities_->writer.matches().count();
}

template <typename Message>
struct Subscription<Message>::Entities {
  void take(std::span<const std::byte> sample) {
    wire::CdrReader cdr(sample);
    cdr.get(message);
    is_good = cdr.is_good();
  }

  Handler handler;
  Message message{};  ///< keeps its capacity from sample to sample
  bool is_good = false;
  std::optional<wire::DdsReader> reader{};
};

template <typename Message>
Subscription<Message>::Subscription(wire::Participant& participant, std::string_view topic,
                                    Handler handler)
    : entities_(std::make_unique<Entities>()) {
  entities_->handler = std::move(handler);
  entities_->reader.emplace(
      wire::dds_entities(participant), dds_topic(topic), type_of<Message>(),
      reader_qos(ros_name<Message>(), kTraits<Message>),
      [entities = entities_.get()](std::span<const std::byte> sample) {
        entities->take(sample);
      },
      [entities = entities_.get()](const wire::WriterId& writer) {
        if (entities->is_good) entities->handler(entities->message, writer);
      });
}

template <typename Message>
Subscription<Message>::~Subscription() = default;

template <typename Message>
std::size_t Subscription<Message>::matched() const noexcept {
  return entities_->reader->matches().count();
}

template class Publication<Bool>;
template class Publication<Clock>;
template class Publication<DiagnosticArray>;
template class Publication<JointState>;
template class Publication<JointTrajectory>;
template class Publication<Log>;

template class Subscription<Bool>;
template class Subscription<Clock>;
template class Subscription<DiagnosticArray>;
template class Subscription<JointState>;
template class Subscription<JointTrajectory>;
template class Subscription<Log>;

}  // namespace vdrive::ros

// SPDX-License-Identifier: Apache-2.0
#include "ros/endpoints.hpp"

#include "dds/reader.hpp"
#include "dds/writer.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/ros.hpp"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::ros {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

// As nodes of ROS 2 usually have it.
constexpr std::int32_t kDepth = 10;
// What a node that joins late still receives of /rosout.
constexpr std::int32_t kDepthForLate = 100;

/// What writer and reader have in common.
template <typename Qos>
void apply(const Traits& traits, std::int32_t depth, Qos& qos) {
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = depth;
  qos.resource_limits().max_samples = depth;
  qos.resource_limits().allocated_samples = 1;
  qos.data_sharing().off();
  const std::string text = "typehash=" + type_hash(traits.type) + ";";
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
                     " is not the name of a topic: it begins with '/', and its parts have letters, "
                     "digits and '_' and "
                     "begin with no digit";
  if (!name.starts_with('/')) return rule;
  std::string_view rest = name.substr(1);
  while (true) {
    const std::size_t slash = rest.find('/');
    if (!is_part(rest.substr(0, slash))) return rule;
    if (slash == std::string_view::npos) return {};
    rest.remove_prefix(slash + 1);
  }
}

dds::DataWriterQos writer_qos(const Traits& traits) {
  dds::DataWriterQos qos;
  apply(traits, traits.kept_for_late ? kDepthForLate : kDepth, qos);
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = {0, 100'000'000};
  qos.durability().kind =
      traits.kept_for_late ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  // A node that joins was seen to stop a synchronous writer for seconds.
  qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
  qos.writer_data_lifecycle().autodispose_unregistered_instances = false;
  qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  return qos;
}

dds::DataReaderQos reader_qos(const Traits& traits) {
  dds::DataReaderQos qos;
  apply(traits, traits.kept_for_late ? kDepthForLate : kDepth, qos);
  qos.reliability().kind =
      traits.takes_any_writer ? dds::BEST_EFFORT_RELIABILITY_QOS : dds::RELIABLE_RELIABILITY_QOS;
  // Of what is kept for late nodes, the lines before the two have met are wanted, too.
  qos.durability().kind =
      traits.kept_for_late ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  // A sample that claims to be larger than the type allows is dropped. The kernel gives the pages
  // that are written to.
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
  return qos;
}

template <typename Message>
struct Publication<Message>::Entities {
  wire::Writer writer;
};

template <typename Message>
Publication<Message>::Publication(wire::Participant& participant, std::string_view topic)
    : entities_(new Entities{.writer = {wire::dds_entities(participant), dds_topic(topic),
                                        dds::TypeSupport(new MessageType<Message>()),
                                        writer_qos(SupportOf<Message>::kTraits)}}) {}

template <typename Message>
Publication<Message>::~Publication() = default;

template <typename Message>
bool Publication<Message>::write(const Message& message) noexcept {
  return entities_->writer.write(&message);
}

template <typename Message>
std::size_t Publication<Message>::matched() const noexcept {
  return entities_->writer.matches().count();
}

template <typename Message>
struct Subscription<Message>::Entities {
  Handler handler;
  Message message{};  ///< keeps its capacity from sample to sample
  std::optional<wire::Reader> reader{};
};

template <typename Message>
Subscription<Message>::Subscription(wire::Participant& participant, std::string_view topic,
                                    Handler handler)
    : entities_(std::make_unique<Entities>()) {
  entities_->handler = std::move(handler);
  entities_->reader.emplace(wire::dds_entities(participant), dds_topic(topic),
                            dds::TypeSupport(new MessageType<Message>()),
                            reader_qos(SupportOf<Message>::kTraits), &entities_->message,
                            [entities = entities_.get()](const wire::WriterId& writer) {
                              entities->handler(entities->message, writer);
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

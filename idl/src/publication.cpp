// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/publication.hpp"

#include "entities.hpp"
#include "quality.hpp"

#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>

#include <string>

namespace vdrive::wire {

namespace dds = eprosima::fastdds::dds;

template <typename Message>
struct Publication<Message>::Entities final : public dds::DataWriterListener {
  void on_publication_matched(dds::DataWriter* /*writer*/,
                              const dds::PublicationMatchedStatus& status) override {
    matches.update(status.last_subscription_handle, status.current_count_change);
  }

  dds::Publisher* publisher = nullptr;
  dds::DataWriter* writer = nullptr;
  Matches matches;
};

template <typename Message>
Publication<Message>::Publication(Participant& participant)
    : entities_(std::make_unique<Entities>()) {
  auto& parent = participant.entities();
  const std::string topic = std::string(kTopicPrefix) + std::string(Topic<Message>::kName);
  if (parent.permissions && !parent.permissions->may_publish(topic)) {
    throw NotPermitted("the permissions of this identity do not allow to publish " + topic);
  }
  entities_->publisher = parent.publisher;
  entities_->writer = parent.publisher->create_datawriter(
      parent.topic_of<Message>(), writer_qos(quality_of(Topic<Message>::kName)), entities_.get(),
      dds::StatusMask::publication_matched());
  if (entities_->writer == nullptr) {
    throw NetworkError("DDS refuses a writer on topic " + topic);
  }
}

template <typename Message>
Publication<Message>::~Publication() {
  entities_->writer->set_listener(nullptr);
  entities_->publisher->delete_datawriter(entities_->writer);
}

template <typename Message>
bool Publication<Message>::write(const Message& message) noexcept {
  try {
    // The library takes a mutable pointer and does not change the message.
    return entities_->writer->write(const_cast<Message*>(&message));  // NOLINT(*-const-cast)
  } catch (...) {
    return false;
  }
}

template <typename Message>
std::size_t Publication<Message>::matched() const noexcept {
  return entities_->matches.count();
}

template <typename Message>
bool Publication<Message>::wait_for_matched(std::size_t count, std::chrono::milliseconds timeout) {
  return entities_->matches.wait_for(count, timeout);
}

template <typename Message>
bool Publication<Message>::wait_for_match(const Source& source, std::chrono::milliseconds timeout) {
  return entities_->matches.wait_for(source, timeout);
}

template <typename Message>
bool Publication<Message>::wait_for_acknowledged(std::chrono::milliseconds timeout) {
  constexpr std::int64_t kMillisecondsPerSecond = 1'000;
  constexpr std::uint32_t kNanosecondsPerMillisecond = 1'000'000;
  const auto milliseconds = timeout.count();
  return entities_->writer->wait_for_acknowledgments(
             {static_cast<std::int32_t>(milliseconds / kMillisecondsPerSecond),
              static_cast<std::uint32_t>(milliseconds % kMillisecondsPerSecond) *
                  kNanosecondsPerMillisecond}) ==
         eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
}

template class Publication<msg::CommandFrame>;
template class Publication<msg::CommandReply>;
template class Publication<msg::Request>;
template class Publication<msg::Reply>;
template class Publication<msg::StatusFrame>;
template class Publication<msg::AxisStatus>;
template class Publication<msg::AxisParameters>;
template class Publication<msg::Event>;
template class Publication<msg::BenchDescription>;
template class Publication<msg::BenchState>;

}  // namespace vdrive::wire

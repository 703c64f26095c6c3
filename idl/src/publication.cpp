// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/publication.hpp"

#include "writer.hpp"

namespace vdrive::wire {

template <typename Message>
struct Publication<Message>::Entities {
  Writer writer;
};

template <typename Message>
Publication<Message>::Publication(Participant& participant)
    : entities_(new Entities{
          .writer = {participant.entities(), Topic<Message>::kId,
                     eprosima::fastdds::dds::TypeSupport(new MessageType<Message>())}}) {}

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
bool Publication<Message>::wait_for_matched(std::size_t count, std::chrono::milliseconds timeout) {
  return entities_->writer.matches().wait_for(count, timeout);
}

template <typename Message>
bool Publication<Message>::wait_for_match(const Source& source, std::chrono::milliseconds timeout) {
  return entities_->writer.matches().wait_for(source, timeout);
}

template <typename Message>
bool Publication<Message>::wait_for_acknowledged(std::chrono::milliseconds timeout) {
  return entities_->writer.wait_for_acknowledged(timeout);
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

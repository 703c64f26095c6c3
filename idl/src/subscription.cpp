// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/subscription.hpp"

#include "bounds.hpp"
#include "reader.hpp"

#include <atomic>
#include <optional>
#include <utility>

namespace vdrive::wire {

template <typename Message>
struct Subscription<Message>::Entities {
  void deliver(const Source& source) {
    if (within_bounds(message)) {
      handler(message, source);
      return;
    }
    ++malformed;
    if (malformed_handler) malformed_handler(message, source);
  }

  Handler handler;
  Handler malformed_handler;
  std::atomic<std::size_t> malformed{0};
  Message message;  ///< keeps its capacity from sample to sample
  std::optional<Reader> reader;
};

template <typename Message>
Subscription<Message>::Subscription(Participant& participant, Handler handler,
                                    Handler malformed_handler)
    : entities_(std::make_unique<Entities>()) {
  entities_->handler = std::move(handler);
  entities_->malformed_handler = std::move(malformed_handler);
  entities_->reader.emplace(participant.entities(), Topic<Message>::kId,
                            eprosima::fastdds::dds::TypeSupport(new MessageType<Message>()),
                            &entities_->message,
                            [entities = entities_.get()](const Source& source) {
                              entities->deliver(source);
                            });
}

template <typename Message>
Subscription<Message>::~Subscription() = default;

template <typename Message>
std::size_t Subscription<Message>::matched() const noexcept {
  return entities_->reader->matches().count();
}

template <typename Message>
bool Subscription<Message>::wait_for_matched(std::size_t count, std::chrono::milliseconds timeout) {
  return entities_->reader->matches().wait_for(count, timeout);
}

template <typename Message>
bool Subscription<Message>::wait_for_match(const Source& source,
                                           std::chrono::milliseconds timeout) {
  return entities_->reader->matches().wait_for(source, timeout);
}

template <typename Message>
std::size_t Subscription<Message>::malformed() const noexcept {
  return entities_->malformed;
}

template <typename Message>
std::size_t Subscription<Message>::lost() const noexcept {
  return entities_->reader->lost();
}

template class Subscription<msg::CommandFrame>;
template class Subscription<msg::CommandReply>;
template class Subscription<msg::Request>;
template class Subscription<msg::Reply>;
template class Subscription<msg::StatusFrame>;
template class Subscription<msg::AxisStatus>;
template class Subscription<msg::AxisParameters>;
template class Subscription<msg::Event>;
template class Subscription<msg::BenchDescription>;
template class Subscription<msg::BenchState>;

}  // namespace vdrive::wire

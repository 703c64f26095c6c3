// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/subscription.hpp"

#include "bounds.hpp"
#include "entities.hpp"
#include "quality.hpp"

#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>

#include <atomic>
#include <mutex>
#include <string>

namespace vdrive::wire {

namespace dds = eprosima::fastdds::dds;

template <typename Message>
struct Subscription<Message>::Entities final : public dds::DataReaderListener {
  void on_data_available(dds::DataReader* source) override {
    // Each interface has its own receive thread: one of them at a time.
    const std::lock_guard lock(mutex);
    dds::SampleInfo info;
    while (!closed && source->take_next_sample(&message, &info) ==
                          eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) {
        deliver(source_of(info.publication_handle));
      }
    }
  }

  void on_subscription_matched(dds::DataReader* /*reader*/,
                               const dds::SubscriptionMatchedStatus& status) override {
    matches.update(status.last_publication_handle, status.current_count_change);
  }

  void on_sample_lost(dds::DataReader* /*reader*/, const dds::SampleLostStatus& status) override {
    lost += static_cast<std::size_t>(status.total_count_change);
  }

  void on_sample_rejected(dds::DataReader* /*reader*/,
                          const dds::SampleRejectedStatus& status) override {
    lost += static_cast<std::size_t>(status.total_count_change);
  }

  void deliver(const Source& source) {
    if (within_bounds(message)) {
      handler(message, source);
      return;
    }
    ++malformed;
    if (malformed_handler) {
      malformed_handler(message, source);
    }
  }

  Handler handler;
  Handler malformed_handler;
  dds::Subscriber* subscriber = nullptr;
  dds::DataReader* reader = nullptr;
  Matches matches;
  std::atomic<std::size_t> malformed{0};
  std::atomic<std::size_t> lost{0};
  std::mutex mutex;
  bool closed = false;
  Message message;  ///< keeps its capacity from sample to sample
};

template <typename Message>
Subscription<Message>::Subscription(Participant& participant, Handler handler,
                                    Handler malformed_handler)
    : entities_(std::make_unique<Entities>()) {
  entities_->handler = std::move(handler);
  entities_->malformed_handler = std::move(malformed_handler);
  auto& parent = participant.entities();
  entities_->subscriber = parent.subscriber;
  entities_->reader = parent.subscriber->create_datareader(
      parent.topic_of<Message>(), reader_qos(quality_of(Topic<Message>::kName)), entities_.get());
  if (entities_->reader == nullptr) {
    throw NetworkError("DDS refuses a reader on topic " + std::string(Topic<Message>::kName) +
                       (parent.permissions ? ": do the permissions allow to subscribe?" : ""));
  }
}

template <typename Message>
Subscription<Message>::~Subscription() {
  {
    const std::lock_guard lock(entities_->mutex);
    entities_->closed = true;
  }
  entities_->reader->set_listener(nullptr);
  entities_->subscriber->delete_datareader(entities_->reader);
}

template <typename Message>
std::size_t Subscription<Message>::matched() const noexcept {
  return entities_->matches.count();
}

template <typename Message>
bool Subscription<Message>::wait_for_matched(std::size_t count, std::chrono::milliseconds timeout) {
  return entities_->matches.wait_for(count, timeout);
}

template <typename Message>
bool Subscription<Message>::wait_for_match(const Source& source,
                                           std::chrono::milliseconds timeout) {
  return entities_->matches.wait_for(source, timeout);
}

template <typename Message>
std::size_t Subscription<Message>::malformed() const noexcept {
  return entities_->malformed;
}

template <typename Message>
std::size_t Subscription<Message>::lost() const noexcept {
  return entities_->lost;
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

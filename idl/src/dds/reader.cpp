// SPDX-License-Identifier: Apache-2.0
#include "dds/reader.hpp"

#include "dds/quality.hpp"

#include <string>
#include <utility>

namespace vdrive::wire {

namespace dds = eprosima::fastdds::dds;

Reader::Reader(DdsEntities& parent, TopicId topic, const dds::TypeSupport& type, void* data,
               Deliver deliver)
    : Reader(parent, std::string(kTopicPrefix) + std::string(traits_of(topic).name), type,
             reader_qos(traits_of(topic)), data, std::move(deliver)) {}

Reader::Reader(DdsEntities& parent, const std::string& topic, const dds::TypeSupport& type,
               const dds::DataReaderQos& qos, void* data, Deliver deliver)
    : entities_(parent), data_(data), deliver_(std::move(deliver)), subscriber_(parent.subscriber) {
  auto* const its_topic = parent.topic(topic, type);
  {
    const std::scoped_lock lock(parent.changing);
    reader_ = subscriber_->create_datareader(its_topic, qos, this);
  }
  if (reader_ == nullptr) {
    throw NetworkError(
        "DDS refuses a reader on topic " + topic +
        (parent.permissions ? ": check that the permissions allow this subscription" : ""));
  }
}

Reader::~Reader() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  reader_->set_listener(nullptr);
  const auto deletion = entities_.erase();
  subscriber_->delete_datareader(reader_);
}

void Reader::on_data_available(dds::DataReader* source) {
  // Each interface has its own receive thread: one of them at a time.
  const std::lock_guard lock(mutex_);
  dds::SampleInfo info;
  while (!closed_ && source->take_next_sample(data_, &info) ==
                         eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
    if (info.valid_data) deliver_(endpoint_of(info.publication_handle));
  }
}

void Reader::on_subscription_matched(dds::DataReader* /*reader*/,
                                     const dds::SubscriptionMatchedStatus& status) {
  const EndpointId writer = endpoint_of(status.last_publication_handle);
  if (status.current_count_change > 0) {
    matches_.add(writer);
  } else {
    matches_.remove(writer);
  }
}

void Reader::on_sample_lost(dds::DataReader* /*reader*/, const dds::SampleLostStatus& status) {
  lost_ += static_cast<std::size_t>(status.total_count_change);
}

void Reader::on_sample_rejected(dds::DataReader* /*reader*/,
                                const dds::SampleRejectedStatus& status) {
  lost_ += static_cast<std::size_t>(status.total_count_change);
}

BytesReader::BytesReader(DdsEntities& parent, TopicId topic, SampleSink sink)
    : BytesSink{.take = std::move(sink.take)},
      Reader(parent, topic, dds::TypeSupport(new BytesType(topic)), &sample,
             [deliver = std::move(sink.deliver)](const EndpointId& writer) {
               deliver(writer.source);
             }) {
  sample.take = &take;
}

}  // namespace vdrive::wire

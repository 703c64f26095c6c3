// SPDX-License-Identifier: Apache-2.0
#include "dds/reader.hpp"

#include "dds/quality.hpp"

#include <string>
#include <utility>

namespace vdrive::wire {

DdsReader::DdsReader(DdsEntities& parent, TopicId topic, SampleHandler handler)
    : DdsReader(parent, std::string(kTopicPrefix) + std::string(traits_of(topic).name),
                dds::TypeSupport(new BytesType(topic)), reader_qos(traits_of(topic)),
                std::move(handler.take),
                [deliver = std::move(handler.deliver)](const WriterId& writer) {
                  deliver(writer.source);
                }) {}

DdsReader::DdsReader(DdsEntities& parent, const std::string& topic, const dds::TypeSupport& type,
                     const dds::DataReaderQos& qos,
                     std::function<void(std::span<const std::byte> sample)> take, Deliver deliver)
    : entities_(parent),
      take_(std::move(take)),
      deliver_(std::move(deliver)),
      subscriber_(parent.subscriber) {
  sample_.take = &take_;
  auto* const its_topic = parent.topic(topic, type);
  {
    const std::scoped_lock lock(parent.changing);
    reader_ = subscriber_->create_datareader(its_topic, qos, this);
  }
  if (reader_ == nullptr) {
    throw NetworkError(
        "DDS could not create a reader on topic " + topic +
        (parent.permissions ? ": check that the permissions allow this subscription" : ""));
  }
}

DdsReader::~DdsReader() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  reader_->set_listener(nullptr);
  const auto deletion = entities_.erase();
  subscriber_->delete_datareader(reader_);
}

void DdsReader::on_data_available(dds::DataReader* source) {
  // Each interface has its own receive thread: let only one at a time deliver.
  const std::lock_guard lock(mutex_);
  dds::SampleInfo info;
  while (!closed_ && is_ok(source->take_next_sample(&sample_, &info))) {
    if (info.valid_data) deliver_(endpoint_of(info.publication_handle));
  }
}

void DdsReader::on_subscription_matched(dds::DataReader* /*reader*/,
                                        const dds::SubscriptionMatchedStatus& status) {
  const EndpointId writer = endpoint_of(status.last_publication_handle);
  if (status.current_count_change > 0) {
    matches_.add(writer);
  } else {
    matches_.remove(writer);
  }
}

void DdsReader::on_sample_lost(dds::DataReader* /*reader*/, const dds::SampleLostStatus& status) {
  lost_ += static_cast<std::size_t>(status.total_count_change);
}

void DdsReader::on_sample_rejected(dds::DataReader* /*reader*/,
                                   const dds::SampleRejectedStatus& status) {
  lost_ += static_cast<std::size_t>(status.total_count_change);
}

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend.hpp"
#include "dds/bytes_type.hpp"
#include "dds/entities.hpp"

#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>

#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <span>
#include <string>

namespace vdrive::wire {

/// The DDS reader of a topic, who matches it and what it lost. Samples are delivered one at a time.
class Reader : public ReaderEnd, public eprosima::fastdds::dds::DataReaderListener {
 public:
  /// Runs for each sample that was taken into the `data` of the constructor.
  using Deliver = std::function<void(const WriterId& writer)>;

  /// @param data what the type support fills; outlives this
  /// @throws NetworkError as `Subscription` does
  Reader(DdsEntities& parent, TopicId topic, const eprosima::fastdds::dds::TypeSupport& type,
         void* data, Deliver deliver);

  /// The same on a topic of another contract.
  /// @param topic in full
  Reader(DdsEntities& parent, const std::string& topic,
         const eprosima::fastdds::dds::TypeSupport& type,
         const eprosima::fastdds::dds::DataReaderQos& qos, void* data, Deliver deliver);
  ~Reader() override;  ///< nothing is delivered after this returns
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  [[nodiscard]] std::size_t lost() const noexcept override { return lost_; }

  void on_data_available(eprosima::fastdds::dds::DataReader* source) override;
  void on_subscription_matched(
      eprosima::fastdds::dds::DataReader* reader,
      const eprosima::fastdds::dds::SubscriptionMatchedStatus& status) override;
  void on_sample_lost(eprosima::fastdds::dds::DataReader* reader,
                      const eprosima::fastdds::dds::SampleLostStatus& status) override;
  void on_sample_rejected(eprosima::fastdds::dds::DataReader* reader,
                          const eprosima::fastdds::dds::SampleRejectedStatus& status) override;

 private:
  const DdsEntities& entities_;
  void* data_;
  Deliver deliver_;
  eprosima::fastdds::dds::Subscriber* subscriber_ = nullptr;
  eprosima::fastdds::dds::DataReader* reader_ = nullptr;
  std::atomic<std::size_t> lost_{0};
  std::mutex mutex_;
  bool closed_ = false;
};

/// What a reader of bytes fills; there before the reader is.
struct BytesSink {
  std::function<void(std::span<const std::byte>)> take;
  BytesSample sample{};
};

/// A reader that passes samples on as bytes.
class BytesReader final : private BytesSink, public Reader {
 public:
  BytesReader(DdsEntities& parent, TopicId topic, SampleSink sink);
};

}  // namespace vdrive::wire

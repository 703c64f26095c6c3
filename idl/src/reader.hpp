// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "entities.hpp"

#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>

#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>

namespace vdrive::wire {

/// The DDS reader of a topic, who matches it and what it lost; what subscriptions of messages and
/// of bytes share. Samples are delivered one at a time.
class Reader final : public eprosima::fastdds::dds::DataReaderListener {
 public:
  /// Runs for each sample that was taken into the `data` of the constructor.
  using Deliver = std::function<void(const WriterId& writer)>;

  /// @param data what the type support fills; outlives this
  /// @throws NetworkError as `Subscription` does
  Reader(Participant::Entities& parent, TopicId topic,
         const eprosima::fastdds::dds::TypeSupport& type, void* data, Deliver deliver);

  /// The same on a topic of another contract.
  /// @param topic in full
  Reader(Participant::Entities& parent, const std::string& topic,
         const eprosima::fastdds::dds::TypeSupport& type,
         const eprosima::fastdds::dds::DataReaderQos& qos, void* data, Deliver deliver);
  ~Reader() override;  ///< nothing is delivered after this returns
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  [[nodiscard]] Matches& matches() noexcept { return matches_; }

  [[nodiscard]] std::size_t lost() const noexcept { return lost_; }

  void on_data_available(eprosima::fastdds::dds::DataReader* source) override;
  void on_subscription_matched(
      eprosima::fastdds::dds::DataReader* reader,
      const eprosima::fastdds::dds::SubscriptionMatchedStatus& status) override;
  void on_sample_lost(eprosima::fastdds::dds::DataReader* reader,
                      const eprosima::fastdds::dds::SampleLostStatus& status) override;
  void on_sample_rejected(eprosima::fastdds::dds::DataReader* reader,
                          const eprosima::fastdds::dds::SampleRejectedStatus& status) override;

 private:
  void* data_;
  Deliver deliver_;
  eprosima::fastdds::dds::Subscriber* subscriber_ = nullptr;
  eprosima::fastdds::dds::DataReader* reader_ = nullptr;
  Matches matches_;
  std::atomic<std::size_t> lost_{0};
  std::mutex mutex_;
  bool closed_ = false;
};

}  // namespace vdrive::wire

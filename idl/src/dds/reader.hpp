// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dds/bytes_type.hpp"
#include "dds/entities.hpp"
#include "vdrive/wire/sample_reader.hpp"
#include "vdrive/wire/writer_id.hpp"

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

/// The DDS reader of a topic, with its matches and losses. Samples are delivered one at a time.
class DdsReader final : public SampleReader, public dds::DataReaderListener {
 public:
  /// Called after `take` for each sample.
  using Deliver = std::function<void(const WriterId& writer)>;

  /// @throws NetworkError as Participant::make_reader does
  DdsReader(DdsEntities& parent, TopicId topic, SampleHandler handler);

  /// The same for a topic of another contract.
  /// @param topic its full name
  DdsReader(DdsEntities& parent, const std::string& topic, const dds::TypeSupport& type,
            const dds::DataReaderQos& qos,
            std::function<void(std::span<const std::byte> sample)> take, Deliver deliver);
  ~DdsReader() override;  ///< nothing is delivered after this returns
  DdsReader(const DdsReader&) = delete;
  DdsReader& operator=(const DdsReader&) = delete;

  [[nodiscard]] std::size_t lost() const noexcept override { return lost_; }

  void on_data_available(dds::DataReader* source) override;
  void on_subscription_matched(dds::DataReader* reader,
                               const dds::SubscriptionMatchedStatus& status) override;
  void on_sample_lost(dds::DataReader* reader, const dds::SampleLostStatus& status) override;
  void on_sample_rejected(dds::DataReader* reader,
                          const dds::SampleRejectedStatus& status) override;

 private:
  const DdsEntities& entities_;
  std::function<void(std::span<const std::byte>)> take_;
  Deliver deliver_;
  BytesSample sample_;
  dds::Subscriber* subscriber_ = nullptr;
  dds::DataReader* reader_ = nullptr;
  std::atomic<std::size_t> lost_{0};
  std::mutex mutex_;
  bool closed_ = false;
};

}  // namespace vdrive::wire

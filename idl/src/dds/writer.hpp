// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend.hpp"
#include "dds/entities.hpp"

#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>

#include <chrono>
#include <mutex>
#include <string>
#include <vector>

namespace vdrive::wire {

/// The DDS writer of a topic and who matches it.
class Writer : public WriterEnd, public eprosima::fastdds::dds::DataWriterListener {
 public:
  /// @param observer runs with who matches, whenever it has changed
  /// @throws NotPermitted, NetworkError as `Publication` does
  Writer(DdsEntities& parent, TopicId topic, const eprosima::fastdds::dds::TypeSupport& type,
         Observer observer = nullptr);

  /// The same on a topic of another contract.
  /// @param name of the topic, in full
  Writer(DdsEntities& parent, const std::string& name,
         const eprosima::fastdds::dds::TypeSupport& type,
         const eprosima::fastdds::dds::DataWriterQos& qos, Observer observer = nullptr);
  ~Writer() override;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// @param data what the type support takes; it is not changed
  bool write(const void* data) noexcept override;

  [[nodiscard]] bool wait_for_acknowledged(std::chrono::milliseconds timeout) override;

  void on_publication_matched(
      eprosima::fastdds::dds::DataWriter* writer,
      const eprosima::fastdds::dds::PublicationMatchedStatus& status) override;

 private:
  eprosima::fastdds::dds::Publisher* publisher_ = nullptr;
  eprosima::fastdds::dds::DataWriter* writer_ = nullptr;
  std::mutex observing_;  ///< the newest list is reported last
  Observer observer_;
};

/// A writer of samples that were encoded elsewhere.
class BytesWriter final : public Writer {
 public:
  BytesWriter(DdsEntities& parent, TopicId topic, Observer observer);

  /// @param data a std::span<const std::byte>
  bool write(const void* data) noexcept override;
};

}  // namespace vdrive::wire

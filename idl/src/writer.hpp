// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "entities.hpp"

#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

namespace vdrive::wire {

/// The DDS writer of a topic and who matches it; what publications of messages and of bytes share.
class Writer final : public eprosima::fastdds::dds::DataWriterListener {
 public:
  /// @param observer runs with who matches, whenever it has changed
  /// @throws NotPermitted, NetworkError as `Publication` does
  Writer(Participant::Entities& parent, TopicId topic,
         const eprosima::fastdds::dds::TypeSupport& type,
         std::function<void(const std::vector<Source>&)> observer = nullptr);

  /// The same on a topic of another contract.
  /// @param name of the topic, in full
  Writer(Participant::Entities& parent, const std::string& name,
         const eprosima::fastdds::dds::TypeSupport& type,
         const eprosima::fastdds::dds::DataWriterQos& qos,
         std::function<void(const std::vector<Source>&)> observer = nullptr);
  ~Writer() override;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// @param data what the type support takes; it is not changed
  bool write(const void* data) noexcept;

  [[nodiscard]] Matches& matches() noexcept { return matches_; }

  [[nodiscard]] bool wait_for_acknowledged(std::chrono::milliseconds timeout);

  void on_publication_matched(
      eprosima::fastdds::dds::DataWriter* writer,
      const eprosima::fastdds::dds::PublicationMatchedStatus& status) override;

 private:
  eprosima::fastdds::dds::Publisher* publisher_ = nullptr;
  eprosima::fastdds::dds::DataWriter* writer_ = nullptr;
  Matches matches_;
  std::mutex observing_;  ///< the newest list is reported last
  std::function<void(const std::vector<Source>&)> observer_;
};

}  // namespace vdrive::wire

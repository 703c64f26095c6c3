// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend.hpp"
#include "dds/entities.hpp"

#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>

#include <atomic>
#include <chrono>
#include <cstdint>
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
  using Clock = std::chrono::steady_clock;

  /// After this a reader that has joined has acknowledged something, or is gone.
  static constexpr std::chrono::seconds kLongestSilence{5};

  void remove_acknowledged();

  const DdsEntities& entities_;
  eprosima::fastdds::dds::Publisher* publisher_ = nullptr;
  eprosima::fastdds::dds::DataWriter* writer_ = nullptr;
  bool forgets_ = false;       ///< reliable, and no later reader gets what was sent
  std::mutex writing_;         ///< of one that forgets: no write between the check and the removal
  std::uint32_t writes_ = 0;   ///< since the last removal, while one is due
  Clock::time_point written_;  ///< the last of them
  Clock::time_point removed_;  ///< the last time at which all were acknowledged
  /// When the last reader joined.
  std::atomic<Clock::time_point> joined_{Clock::time_point{} - kLongestSilence};

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

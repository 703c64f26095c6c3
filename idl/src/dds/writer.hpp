// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dds/entities.hpp"
#include "vdrive/wire/sample_writer.hpp"
#include "vdrive/wire/topics.hpp"

#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

namespace vdrive::wire {

/// The DDS writer of a topic, with its matches.
class DdsWriter final : public SampleWriter, public dds::DataWriterListener {
 public:
  /// @param observer called with the matching participants whenever they change
  /// @throws NotPermitted, NetworkError as Participant::make_writer does
  DdsWriter(DdsEntities& parent, TopicId topic, Observer observer);

  /// The same for a topic of another contract.
  /// @param name full name of the topic
  DdsWriter(DdsEntities& parent, const std::string& name, const dds::TypeSupport& type,
            const dds::DataWriterQos& qos, Observer observer = nullptr);
  ~DdsWriter() override;
  DdsWriter(const DdsWriter&) = delete;
  DdsWriter& operator=(const DdsWriter&) = delete;

  [[nodiscard]] bool write(std::span<const std::byte> sample) noexcept override;

  [[nodiscard]] bool wait_for_acknowledged(std::chrono::milliseconds timeout) override;

  void on_publication_matched(dds::DataWriter* writer,
                              const dds::PublicationMatchedStatus& status) override;

 private:
  using Clock = std::chrono::steady_clock;

  /// A reader that has joined acknowledges something within this time, or is gone.
  static constexpr std::chrono::seconds kLongestSilence{5};

  void remove_acknowledged();

  const DdsEntities& entities_;
  dds::Publisher* publisher_ = nullptr;
  dds::DataWriter* writer_ = nullptr;
  bool forgets_ = false;       ///< reliable and volatile: late readers get no earlier samples
  std::mutex writing_;         ///< if forgets_: no write between the check and the removal
  std::uint32_t writes_ = 0;   ///< since the last removal or wait; counted while a removal is due
  Clock::time_point written_;  ///< time of the last write
  Clock::time_point removed_;  ///< last time at which everything was acknowledged
  /// Time at which the last reader joined.
  std::atomic<Clock::time_point> joined_{Clock::time_point{} - kLongestSilence};

  std::mutex observing_;  ///< keeps the reports to `observer_` in the order of the matches
  Observer observer_;
};

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "guard/writer_numbers.hpp"
#include "vdrive/wire/participant.hpp"

#include <fastdds/dds/domain/DomainParticipantListener.hpp>

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

/// The other participants that the library knows, by its own reports. The library's function for
/// this, DomainParticipant::get_participant_names, reads its list without the lock under which its
/// receiving threads change it. Thread-safe.
class Others final : public eprosima::fastdds::dds::DomainParticipantListener {
 public:
  /// @param numbers learns who is known; outlives this. Call before there is a participant.
  void tell(WriterNumbers& numbers) noexcept { numbers_ = &numbers; }

  /// @return those whose name has this beginning.
  [[nodiscard]] std::vector<OtherParticipant> named(std::string_view beginning) const;

  /// Runs in a thread of the library that holds none of its locks for participants. What it is
  /// about is valid: a participant is added and removed by one thread at a time (Guard).
  void on_participant_discovery(eprosima::fastdds::dds::DomainParticipant* participant,
                                eprosima::fastrtps::rtps::ParticipantDiscoveryInfo&& info) override;

 private:
  mutable std::mutex mutex_;
  std::map<eprosima::fastrtps::rtps::GuidPrefix_t, OtherParticipant> known_;
  WriterNumbers* numbers_ = nullptr;  ///< of the guard; none without
};

}  // namespace vdrive::wire

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dds/library/library.hpp"
#include "guard/guard.hpp"
#include "vdrive/wire/participant.hpp"

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

/// The other participants that the library has reported. Replaces a function of Fast DDS 2.9 and
/// 3.1, DomainParticipant::get_participant_names, which reads its list without the lock under which
/// the receive threads change it. Thread-safe.
class KnownParticipants final : public ParticipantListener {
 public:
  /// @param guard is told which participants are known, and tells which of them use DDS Security;
  ///        must outlive this object. Call before there is a participant.
  void tell(Guard& guard) noexcept { guard_ = &guard; }

  /// @return those whose names start with `beginning`.
  [[nodiscard]] std::vector<OtherParticipant> named(std::string_view beginning) const;

  /// @return whether a discovery server is among them.
  [[nodiscard]] bool has_server() const;

 private:
  // Called in a thread of the library that holds none of its participant locks. The arguments stay
  // valid, because only one thread at a time adds or removes participants (Guard).
  void find(const rtps::GUID_t& guid, const std::string& name,
            const std::vector<rtps::octet>& user_data) override;
  void lose(const rtps::GUID_t& guid) override;

  mutable std::mutex mutex_;
  std::map<rtps::GuidPrefix_t, OtherParticipant> known_;
  Guard* guard_ = nullptr;  ///< null without one
};

}  // namespace vdrive::wire

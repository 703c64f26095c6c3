// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/distances.hpp"
#include "judge/findings.hpp"
#include "judge/record.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <optional>

namespace vdrive::judge {

/// Multiple writers of an object, PDOs, SYNC (CiA 301).
class NetworkRules {
 public:
  /// To be called before the track of `context` is updated with the write.
  void take(const Write& write, const Context& context);
  void take(const ReceivePdo& pdo, const Context& context);
  void take(const Sync& sync, const Context& context);
  void take(const Network& network);

  void forget();

 private:
  struct Pdo {
    std::optional<std::uint8_t> type;  ///< transmission type, if known
    std::uint32_t since_sync = 0;
    std::uint32_t without_sync = 0;
    std::uint32_t one_a_cycle = 0;  ///< SYNC cycles in a row with exactly one frame
    Time first_without_sync{};
  };

  static void wait_for_sync(std::uint16_t number, Pdo& pdo, const Context& context);
  static void end_cycle(std::uint16_t number, Pdo& pdo, const Context& context);
  void judge_period(const Context& context);

  /// The values written to an object that is mapped in a PDO.
  struct Shared {
    std::int64_t of_pdo = 0;             ///< value of the last PDO
    std::optional<std::int64_t> of_sdo;  ///< value written by SDO since
    Time pdo_time{};                     ///< of the last PDO
    Time sdo_time{};
  };

  void take_shared(const Write& write, const Context& context);

  std::map<ObjectAddress, Shared> shared_;
  std::map<std::uint16_t, Pdo> pdos_;
  std::optional<Time> last_sync_;
  Distances syncs_;          ///< of the present stream
  bool is_cyclic_ = false;   ///< at the last SYNC
  bool has_target_ = false;  ///< since the last SYNC
  std::optional<Time> last_target_sync_;
  Distances targets_;  ///< between the SYNCs that were followed by a target
  bool is_period_judged_ = false;
  std::uint64_t writer_ = 0;         ///< of the last command
  std::uint64_t writer_before_ = 0;  ///< the other writer, from whom `writer_` took over
  Time writer_since_{};
};

}  // namespace vdrive::judge

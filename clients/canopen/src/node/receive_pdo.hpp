// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "node/pdo_parameters.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::canopen {

// Emergency error codes of RPDOs (CiA 301, table 26).
inline constexpr std::uint16_t kPdoTooShort = 0x8210;
inline constexpr std::uint16_t kPdoTooLong = 0x8220;
inline constexpr std::uint16_t kPdoTimeOut = 0x8250;

/// Set-points of RPDOs that act together in one tick, as NodeHost::command() takes them: each
/// object once with the value that came last, in order of arrival, the controlword (6040h) after
/// all others.
class SetPoints {
 public:
  void put(const DriveValue& value);

  void clear() noexcept { values_.clear(); }

  /// The span ends with the next put() or clear().
  [[nodiscard]] std::span<const DriveValue> values() const noexcept { return values_; }

 private:
  std::vector<DriveValue> values_;
};

/// What an RPDO made of a frame.
struct PdoReception {
  bool is_dropped = false;       ///< the frame is shorter than the mapping
  std::uint16_t error_code = 0;  ///< emergency to raise; 0 = none
};

/// A receive PDO of a node (CiA 301, 7.5.2.35 and 7.5.2.36). Types 0 to 240 act at the next SYNC,
/// 254 and 255 at once. It keeps the data of the frame that came last until take().
class ReceivePdo {
 public:
  explicit ReceivePdo(PdoPlace place);

  /// All objects have their defaults again.
  void reset();

  /// What it has received is forgotten, as are errors; its time-out begins with the next frame.
  void restart();

  /// As PdoParameters::read().
  [[nodiscard]] std::uint32_t read(ObjectAddress object) const { return parameters_.read(object); }

  /// As PdoParameters::write(). Another validity, transmission type or event timer restarts it.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  /// @return whether `frame` is a data frame in the base format with the CAN-ID of this PDO, which
  ///         is valid.
  [[nodiscard]] bool awaits(const Frame& frame) const noexcept;

  [[nodiscard]] bool is_synchronous() const noexcept;

  /// An error of the length is raised once, until a frame comes that has another one or none.
  /// @pre awaits(frame)
  PdoReception receive(const Frame& frame, DriveTime now);

  /// Puts the values of the data received last, if there is some, and forgets it. Integers get
  /// their sign; dummies are left out.
  /// @return whether there was some.
  bool take(SetPoints& set_points);

  /// @return whether the event timer (:05) has elapsed since the frame received last: once, until
  ///         another frame comes.
  bool times_out(DriveTime now);

  /// @return whether an error lasts: of the length, until a frame with the right one comes; the
  ///         time-out, until one comes that is used; both no longer than until restart().
  [[nodiscard]] bool has_error() const noexcept { return length_error_ != 0 || is_timed_out_; }

  /// @return when it times out; none = it does not.
  [[nodiscard]] std::optional<DriveTime> next_due() const;

 private:
  PdoParameters parameters_;
  std::optional<Frame> latched_{};
  std::optional<DriveTime> received_{};  ///< of the time-out that runs
  std::uint16_t length_error_ = 0;       ///< of the frame received last
  bool is_timed_out_ = false;
};

}  // namespace vdrive::canopen

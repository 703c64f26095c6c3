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
/// object once with its latest value, in order of arrival, the controlword (6040h) after all
/// others.
class SetPoints {
 public:
  void put(const DriveValue& value);

  void clear() noexcept { values_.clear(); }

  /// The span is valid until the next put() or clear().
  [[nodiscard]] std::span<const DriveValue> values() const noexcept { return values_; }

 private:
  std::vector<DriveValue> values_;
};

/// The outcome of a received RPDO.
struct PdoReception {
  bool is_dropped = false;       ///< the frame is shorter than the mapping
  std::uint16_t error_code = 0;  ///< emergency to raise; 0 = none
};

/// A receive PDO of a node (CiA 301, 7.5.2.35 and 7.5.2.36). Types 0 to 240 act at the next SYNC,
/// 254 and 255 immediately. It keeps the data of the latest frame until take().
class ReceivePdo {
 public:
  explicit ReceivePdo(PdoPlace place);

  /// Sets all objects back to their defaults.
  void reset();

  /// Forgets received data and errors; the time-out starts with the next frame.
  void restart();

  /// As PdoParameters::read().
  [[nodiscard]] std::uint32_t read(ObjectAddress object) const { return parameters_.read(object); }

  /// As PdoParameters::write(). A change of validity, transmission type or event timer restarts the
  /// PDO.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  /// @return whether the PDO is valid and `frame` is a data frame in the base format with its
  ///         CAN-ID.
  [[nodiscard]] bool awaits(const Frame& frame) const noexcept;

  [[nodiscard]] bool is_synchronous() const noexcept;

  /// A length error is raised once, and again only after a frame with another error or with none.
  /// @pre awaits(frame)
  PdoReception receive(const Frame& frame, DriveTime now);

  /// Moves the values of the latest data, if any, into `set_points`. Signed integers are
  /// sign-extended; dummies are left out.
  /// @return whether there was data.
  bool take(SetPoints& set_points);

  /// @return whether the event timer (:05) has elapsed since the latest frame; true only once per
  ///         frame.
  bool times_out(DriveTime now);

  /// @return whether an error lasts: a length error until a frame of the right length arrives, a
  ///         time-out until a frame is accepted, both at the longest until restart().
  [[nodiscard]] bool has_error() const noexcept { return length_error_ != 0 || is_timed_out_; }

  /// @return when it times out; none = never.
  [[nodiscard]] std::optional<DriveTime> next_due() const;

 private:
  PdoParameters parameters_;
  std::optional<Frame> latched_{};
  std::optional<DriveTime> received_{};  ///< start of the running time-out
  std::uint16_t length_error_ = 0;       ///< of the latest frame
  bool is_timed_out_ = false;
};

}  // namespace vdrive::canopen

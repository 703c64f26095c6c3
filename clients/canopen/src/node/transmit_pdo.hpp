// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "node/pdo_parameters.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdrive::canopen {

/// A transmit PDO of a node (CiA 301, 7.5.2.37 and 7.5.2.38). It returns the frames that are due:
///
/// | type | sent |
/// | --- | --- |
/// | 0 | at a SYNC, if its bytes differ from those sent last |
/// | 1 to 240 | at every n-th SYNC |
/// | 252 | when requested (RTR), with the bytes of the last SYNC |
/// | 253 | when requested, with the present bytes |
/// | 254, 255 | when its bytes differ from those sent last, when the event timer (:05) has elapsed
/// | | | since, when requested; with at least the inhibit time (:03) between two frames |
///
/// Remote frames are answered while bit 30 of the COB-ID is 0. A frame that falls due within an
/// inhibit time is sent once, at its end, with the bytes current at that moment. With a SYNC
/// counter and a SYNC start value (:06), types 0 to 240 begin to count at the SYNC with this
/// number.
///
/// An object that the status does not contain is sent with the latest value of set_value(). From
/// the moment the PDO becomes valid until each such object has a value, nothing is sent and no SYNC
/// counts: a PDO never carries a value that the drive did not have.
class TransmitPdo {
 public:
  explicit TransmitPdo(PdoPlace place);

  /// Sets all objects back to their defaults.
  void reset();

  /// Forgets all frames sent: an event-driven PDO is due.
  void restart();

  /// As PdoParameters::read().
  [[nodiscard]] std::uint32_t read(ObjectAddress object) const { return parameters_.read(object); }

  /// As PdoParameters::write(). A change of validity or transmission type restarts the PDO.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  /// Adds to `objects`, each once, those that the PDO carries and the status does not contain; none
  /// while the PDO is not valid.
  void add_read_objects(std::vector<ObjectAddress>& objects) const;

  /// The drive's value of an object of add_read_objects(); other objects are ignored.
  void set_value(const DriveValue& reading);

  /// @param counter of the SYNC, 1 to 240; 0 = none
  /// @return the frame to send at this SYNC.
  std::optional<Frame> synchronise(const AxisStatus& drive, std::uint8_t counter);

  /// @return whether the PDO is valid, allows remote frames, and `frame` is a remote frame in the
  ///         base format with its CAN-ID.
  [[nodiscard]] bool is_request(const Frame& frame) const noexcept;

  /// @pre is_request() of the received frame
  /// @return the answer; none for types 0 to 240, and within an inhibit time.
  std::optional<Frame> answer(const AxisStatus& drive, DriveTime now);

  /// @return the frame of an event-driven PDO that is due.
  std::optional<Frame> send_due(const AxisStatus& drive, DriveTime now);

  /// @return when send_due() is next due if the drive does not change, 0 = immediately; none = no
  ///         timer is running.
  [[nodiscard]] std::optional<DriveTime> next_due() const;

 private:
  [[nodiscard]] bool is_event_driven() const noexcept;
  [[nodiscard]] bool has_begun(std::uint8_t counter);
  [[nodiscard]] bool is_inhibited(DriveTime now) const;
  [[nodiscard]] bool has_event(const Frame& present, DriveTime now) const;
  void forget_values();
  void note_missing_values();
  [[nodiscard]] bool has_value(const MappedObject& object) const;
  [[nodiscard]] std::int64_t value_of(const MappedObject& object, const AxisStatus& drive) const;
  [[nodiscard]] Frame frame_of(const AxisStatus& drive) const;
  Frame mark_sent(const Frame& frame, DriveTime now);

  PdoParameters parameters_;
  std::optional<Frame> sent_{};    ///< last, types 0, 254 and 255
  DriveTime sent_at_{};            ///< of `sent_`, types 254 and 255
  std::optional<Frame> sample_{};  ///< of the last SYNC, type 252
  std::uint8_t sync_count_ = 0;    ///< SYNCs since the last frame, types 1 to 240
  bool awaits_sync_start_ = true;  ///< no SYNC has counted so far
  bool is_requested_ = false;      ///< a remote frame is still unanswered, types 254 and 255
  bool is_waiting_ = false;        ///< for the end of the inhibit time
  std::vector<DriveValue> read_;   ///< values of set_value() since the PDO became valid
  bool misses_values_ = false;     ///< an object that it carries has no value
};

}  // namespace vdrive::canopen

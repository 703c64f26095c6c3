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

/// A transmit PDO of a node (CiA 301, 7.5.2.37 and 7.5.2.38). It gives the frames that have become
/// due:
///
/// | type | sent |
/// | --- | --- |
/// | 0 | at a SYNC, when its bytes differ from those sent last |
/// | 1 to 240 | at every n-th SYNC |
/// | 252 | when requested (RTR), with the bytes of the last SYNC |
/// | 253 | when requested, with the present bytes |
/// | 254, 255 | when its bytes differ from those sent last, when the event timer (:05) has elapsed
/// | | | since, when requested; the inhibit time (:03) lies between two frames at least |
///
/// Remote frames count while bit 30 of the COB-ID is 0. What falls into an inhibit time is sent
/// once, at its end, with the bytes of then. With a SYNC counter and a SYNC start value (:06), the
/// first SYNC that counts for types 0 to 240 is the one with this number.
///
/// An object that the status does not have is carried with the value that set_value() brought last.
/// Until each of them has one, from the moment on in which the PDO becomes valid, nothing is sent
/// and no SYNC counts: a PDO carries no value that the drive did not have.
class TransmitPdo {
 public:
  explicit TransmitPdo(PdoPlace place);

  /// All objects have their defaults again.
  void reset();

  /// It has sent nothing yet: an event-driven PDO is due.
  void restart();

  /// As PdoParameters::read().
  [[nodiscard]] std::uint32_t read(ObjectAddress object) const { return parameters_.read(object); }

  /// As PdoParameters::write(). Another validity or transmission type restarts it.
  AbortCode write(ObjectAddress object, std::uint32_t value);

  /// Adds the objects to read for it to `objects`, each once: those that it carries and the status
  /// does not have; none while it is not valid.
  void add_read_objects(std::vector<ObjectAddress>& objects) const;

  /// What the drive has for one of them; another object is ignored.
  void set_value(const DriveValue& reading);

  /// @param counter of the SYNC, 1 to 240; 0 = it has none
  /// @return the frame to send at this SYNC.
  std::optional<Frame> synchronise(const AxisStatus& drive, std::uint8_t counter);

  /// @return whether `frame` is a remote frame in the base format with the CAN-ID of this PDO, and
  ///         the PDO is valid and allows it.
  [[nodiscard]] bool is_request(const Frame& frame) const noexcept;

  /// @pre is_request() of the frame that has come
  /// @return the answer; none for types 0 to 240, and within an inhibit time.
  std::optional<Frame> answer(const AxisStatus& drive, DriveTime now);

  /// @return the frame of an event-driven PDO that is due.
  std::optional<Frame> send_due(const AxisStatus& drive, DriveTime now);

  /// @return when send_due() has something to do while the drive stays as it is, 0 = at once;
  ///         nothing when it waits for no time.
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
  bool awaits_sync_start_ = true;  ///< no SYNC has counted yet
  bool is_requested_ = false;      ///< a remote frame has not been answered, types 254 and 255
  bool is_waiting_ = false;        ///< for the end of the inhibit time
  std::vector<DriveValue> read_;   ///< what set_value() brought since it became valid
  bool misses_values_ = false;     ///< of an object that it carries
};

}  // namespace vdrive::canopen

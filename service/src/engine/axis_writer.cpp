// SPDX-License-Identifier: Apache-2.0
#include "engine/axis_writer.hpp"

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/dictionary/object_table.hpp"

namespace vdrive::service {

using namespace vdrive::literals;

AxisWriter::AxisWriter(BenchAxes& axes, FrameSchedule& schedule)
    : axes_(axes), schedule_(schedule) {}

AbortCode AxisWriter::write(std::size_t axis, ObjectRow row, std::int64_t value) {
  const bool halts = schedule_.size() > 0 && begins_halt(axis, row, value);
  const AbortCode code = axes_.write(axis, row, value);
  if (code == AbortCode::none && halts) schedule_.cancel_of_axis(axes_.number_of(axis));
  return code;
}

bool AxisWriter::begins_halt(std::size_t axis, ObjectRow row, std::int64_t value) const noexcept {
  return row == "ds402_controlword"_object && (value & Controlword::kHalt) != 0 &&
         (axes_.bank().read(axis, row).value & Controlword::kHalt) == 0;
}

}  // namespace vdrive::service

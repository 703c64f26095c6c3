// SPDX-License-Identifier: Apache-2.0
#include "vdrive/plant/model_parameters.hpp"

#include "vdrive/number_text.hpp"

#include <stdexcept>

namespace vdrive {
namespace {

/// If one of the end stops is missing, there is no room to check.
bool has_room_between_stops(const AxisModel& model) {
  return model.lower_end_stop == kNoLowerEndStop || model.upper_end_stop == kNoUpperEndStop ||
         model.lower_end_stop < model.upper_end_stop;
}

}  // namespace

std::string with_unit(double number, const ModelParameter& parameter) {
  std::string text = to_text(number);
  if (!parameter.unit.empty()) text.append(" ").append(parameter.unit);
  return text;
}

std::optional<std::string> limits_broken(const AxisModel& model, const ModelParameter& parameter) {
  const double value = model.*parameter.member;
  const bool from_zero = parameter.from_zero_if_rigid && model.coupling == Coupling::rigid;
  const double lowest = from_zero ? 0.0 : parameter.lowest;
  if (!(value >= lowest && value <= parameter.highest)) {
    return "must be from " + to_text(lowest) + " to " + with_unit(parameter.highest, parameter);
  }
  if (parameter.member == &AxisModel::lower_end_stop && !has_room_between_stops(model)) {
    return "must be below upper_end_stop = " + with_unit(model.upper_end_stop, parameter);
  }
  return std::nullopt;
}

void validate(const AxisModel& model) {
  for (const ModelParameter& parameter : kModelParameters) {
    if (const auto limits = limits_broken(model, parameter)) {
      throw std::invalid_argument(std::string(parameter.name) + " = " +
                                  to_text(model.*parameter.member) + ": " + *limits);
    }
  }
}

}  // namespace vdrive

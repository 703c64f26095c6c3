// SPDX-License-Identifier: Apache-2.0
#include "vdrive/plant/model_parameters.hpp"

#include "vdrive/number_text.hpp"

#include <stdexcept>

namespace vdrive {

std::optional<std::string> limits_broken(const AxisModel& model, const ModelParameter& parameter) {
  const double value = model.*parameter.member;
  const bool from_zero = parameter.from_zero_if_rigid && model.coupling == Coupling::rigid;
  const double lowest = from_zero ? 0.0 : parameter.lowest;
  if (value >= lowest && value <= parameter.highest) return std::nullopt;
  return "must be from " + to_text(lowest) + " to " + to_text(parameter.highest) + " " +
         std::string(parameter.unit);
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

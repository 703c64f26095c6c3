// SPDX-License-Identifier: Apache-2.0
// A bench in the interpreter's process.
#include "local_bench.hpp"

#include "interpreter_lock.hpp"
#include "vdrive/clock_mode.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace vdrive::python {
namespace {

constexpr std::array kDefaultFirst{ClockMode::lockstep, ClockMode::realtime, ClockMode::freerun};

ClockMode clock_of(const std::string& name) {
  if (const auto mode = clock_mode_named(name)) return *mode;
  throw py::value_error("clock = " + name + ": no clock mode");
}

py::tuple names_of_clock_modes() {
  py::tuple names(kDefaultFirst.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    names[i] = std::string(to_string(kDefaultFirst.at(i)));
  }
  return names;
}

std::shared_ptr<LocalBench> make(std::optional<std::size_t> axes, const std::string& preset,
                                 const std::string& config, const std::string& clock,
                                 std::optional<std::uint32_t> number, const std::string& state,
                                 const std::string& journal,
                                 const std::shared_ptr<LocalBench>& beside) {
  const bench::BenchOptions options{.configuration_file = config,
                                    .axes = axes,
                                    .preset = preset,
                                    .clock = clock_of(clock),
                                    .number = number,
                                    .state_directory = state,
                                    .journal = journal,
                                    .bus = beside ? beside->bus() : nullptr};
  try {
    const Unlocked unlocked;
    return made_here<LocalBench>(options);
  } catch (const bench::NeedsNetwork& error) {
    raise_configuration_error(std::string(error.what()) + ": vdrive.Bench(..., over=\"dds\")");
  } catch (const bench::BenchError& error) {
    raise_configuration_error(error.what());
  }
}

}  // namespace

std::shared_ptr<wire::LocalBus> LocalBench::bus() const {
  origin_.require_own("the bench");
  if (!bench_) raise(client::Outcome::failed("the bench has ended"));
  return bench_->bus();
}

void LocalBench::close() {
  if (origin_.is_inherited()) return;
  // Without the interpreter lock: a call of another thread may have to end first, and needs it.
  const Unlocked unlocked;
  bench_.reset();
}

void add_local_bench(py::module_& module) {
  py::class_<LocalBench, std::shared_ptr<LocalBench>>(
      module, "LocalBench", "A bench in this process; use it through vdrive.Bench.")
      .def(py::init(&make), py::kw_only(), py::arg("axes") = py::none(), py::arg("preset") = "",
           py::arg("config") = "", py::arg("clock") = "lockstep", py::arg("number") = py::none(),
           py::arg("state") = "", py::arg("journal") = "", py::arg("beside") = py::none(),
           "Makes the bench, on the bus of `beside` if that is given.")
      .def_property_readonly(
          "number",
          [](const LocalBench& self) {
            return self.number();
          },
          "Its number on its bus.")
      .def("close", &LocalBench::close, "Ends the bench.");
  module.attr("CLOCK_MODES") = names_of_clock_modes();
  module.attr("PRESETS") = py::tuple(py::cast(bench::preset_names()));
  module.attr("MOST_AXES") = bench::kMostAxes;
  module.attr("HIGHEST_BENCH") = bench::kHighestNumber;
}

}  // namespace vdrive::python

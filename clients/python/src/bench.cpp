// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"

#include "errors.hpp"
#include "interpreter_lock.hpp"
#include "py_session.hpp"
#include "vdrive/clock_mode.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::python {
namespace {

[[noreturn]] void raise_ended() {
  raise(client::Outcome::failed("the bench has ended"));
}

std::shared_ptr<LocalBench> make_local(std::optional<std::size_t> axes, const std::string& preset,
                                       const std::string& config, const std::string& clock,
                                       std::optional<std::uint32_t> number,
                                       const std::string& state, const std::string& journal,
                                       const std::shared_ptr<LocalBench>& beside) {
  const bench::BenchOptions options{.configuration_file = config,
                                    .axes = axes,
                                    .preset = preset,
                                    .clock = clock_mode_named(clock).value_or(ClockMode::lockstep),
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
  if (!bench_) raise_ended();
  return bench_->bus();
}

void LocalBench::close() {
  if (origin_.is_inherited()) return;
  // Without the interpreter lock: a call of another thread may have to end first, and needs the
  // lock.
  const Unlocked unlocked;
  bench_.reset();
}

std::uint32_t OwnBench::domain() const {
  origin_.require_own("the bench");
  if (bench_.get() == nullptr) raise_ended();
  return bench_.get()->domain();
}

void OwnBench::close() {
  if (origin_.is_inherited()) return;
  const Unlocked unlocked;
  bench_.end();
}

void OwnBench::wait_until_ready() {
  const std::optional<std::string> problem = interruptible(
      [this] {
        bench_.get()->end();
      },
      [] {},
      [this] {
        return bench_.get()->wait_until_ready();
      });
  if (problem) raise(client::Outcome::failed(*problem));
}

void add_bench(py::module_& module) {
  py::class_<LocalBench, std::shared_ptr<LocalBench>>(module, "LocalBench")
      .def(py::init(&make_local))
      .def("close", &LocalBench::close);
  py::class_<OwnBench, std::shared_ptr<OwnBench>>(module, "PrivateBench")
      .def(py::init(&made_here<OwnBench, const std::string&, const std::vector<std::string>&,
                               std::optional<std::uint32_t>>))
      .def("domain", &OwnBench::domain)
      .def("close", &OwnBench::close);
  module.def("find_service", &process::find_service);
  module.attr("CLOCK_MODES") =
      py::make_tuple(to_string(ClockMode::lockstep), to_string(ClockMode::realtime),
                     to_string(ClockMode::freerun));
  module.attr("PRESETS") = py::tuple(py::cast(bench::preset_names()));
  module.attr("MOST_AXES") = bench::kMostAxes;
  module.attr("HIGHEST_BENCH") = bench::kHighestNumber;
  module.attr("HIGHEST_DOMAIN") = process::PrivateBench::highest_domain();
}

}  // namespace vdrive::python

// SPDX-License-Identifier: Apache-2.0
// Recordings of the tool as arrays of numpy.
#include "recording.hpp"

#include "convert.hpp"
#include "python.hpp"
#include "status.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

using client::Observation;

struct Loaded {
  recording::Contents contents;
  std::map<std::uint32_t, std::deque<Observation>> samples;  ///< by bench
};

/// Without the interpreter lock. @throws recording::RecordingError
Loaded load(const std::string& path) {
  Loaded loaded;
  loaded.contents = recording::read_recording(path, [&loaded](const Observation& sample) {
    loaded.samples[sample.axes.front().id.bench].push_back(sample);
  });
  return loaded;
}

bool have_same_axes(const Observation& one, const Observation& other) {
  return std::ranges::equal(one.axes, other.axes, {}, &client::AxisSnapshot::id,
                            &client::AxisSnapshot::id);
}

/// @return the period of the bench [s]; None of a format that does not have it.
py::object tick_period_of(const std::string& path, std::uint32_t number,
                          const recording::Contents& contents) {
  if (recording::format_of(path) != recording::Format::mcap) return py::none();
  const auto bench = std::ranges::find(contents.benches, number, &recording::RecordedBench::number);
  if (bench == contents.benches.end()) return py::none();
  return py::float_(std::chrono::duration<double>(bench->period).count());
}

py::tuple bench_of(const std::string& path, std::uint32_t number, const py::object& period,
                   const std::deque<Observation>& samples,
                   const std::map<client::AxisId, std::string>& known) {
  py::list axes;
  py::list names;
  for (const client::AxisSnapshot& axis : samples.front().axes) {
    const auto name = known.find(axis.id);
    axes.append(to_string(axis.id));
    names.append(name == known.end() ? "" : name->second);
  }
  for (const Observation& sample : samples) {
    if (!have_same_axes(sample, samples.front())) {
      throw py::value_error(path + ": its axes have different ticks");
    }
  }
  return py::make_tuple(number, period, axes, names,
                        frames_of(samples, samples.front().axes.size()));
}

py::tuple read_recording(const std::string& path) {
  load_numpy();
  Loaded loaded;
  std::string problem;
  {
    const py::gil_scoped_release unlocked;
    try {
      loaded = load(path);
    } catch (const recording::RecordingError& error) {
      problem = error.what();
    }
  }
  if (!problem.empty()) throw py::value_error(problem);
  const auto names = recording::names_of(loaded.contents.benches);
  py::list benches;
  for (const auto& [number, samples] : loaded.samples) {
    benches.append(
        bench_of(path, number, tick_period_of(path, number, loaded.contents), samples, names));
  }
  return py::make_tuple(loaded.contents.cut, benches);
}

}  // namespace

void add_recording(py::module_& module) {
  module.def("read_recording", &read_recording, py::arg("path"),
             "Reads a recording; its ending is its format. Returns where the file ends before its "
             "end, empty for a whole one, and for each bench its number, period [s] where the "
             "format has it, axes, names of the axes and array of records.");
}

}  // namespace vdrive::python

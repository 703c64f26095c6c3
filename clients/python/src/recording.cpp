// SPDX-License-Identifier: Apache-2.0
// Recordings of the tool as numpy arrays.
#include "recording.hpp"

#include "convert.hpp"
#include "interpreter_lock.hpp"
#include "python.hpp"
#include "sample_order.hpp"
#include "status.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
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

/// Called without the interpreter lock.
/// @throws recording::RecordingError
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

/// @return the period of the bench [s]; None if the format does not contain it.
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
      throw py::value_error(path + ": its axes were not recorded at the same ticks");
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
    const Unlocked unlocked;
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

/// A recording of one bench that a program wants to save.
struct Saved {
  recording::RecordedBench bench;
  client::Observation sample;  ///< its axes have their addresses set
  bool has_period = false;
};

/// @throws py::value_error if an axis address is invalid, or the axes are of several benches
Saved saved_of(const std::vector<std::string>& axes, const std::vector<std::string>& names,
               std::optional<std::int64_t> period) {
  Saved saved;
  if (axes.size() != names.size()) {
    throw py::value_error("the recording has " + std::to_string(axes.size()) + " axes and " +
                          std::to_string(names.size()) + " names");
  }
  for (std::size_t place = 0; place < axes.size(); ++place) {
    const auto id = client::parse_axis_id(axes[place]);
    if (!id)
      throw py::value_error("axis " + in_quotes(axes[place]) + " is not an address such as 1.2");
    saved.sample.axes.emplace_back().id = *id;
    if (id->bench != saved.sample.axes.front().id.bench) {
      throw py::value_error("the axes " + axes.front() + " and " + axes[place] +
                            " are on different benches");
    }
    saved.bench.axes.push_back({.id = *id, .name = names[place]});
    saved.bench.number = id->bench;
  }
  const std::chrono::nanoseconds tick(period.value_or(0));
  saved.has_period = tick > std::chrono::nanoseconds(0);
  if (saved.has_period) saved.bench.period = tick;
  recording::name_topics(saved.bench);
  return saved;
}

/// Refuses samples that no reader would accept.
/// @throws recording::RecordingError
void check_samples(const FrameView& frames, Saved& saved) {
  recording::SampleOrder order;
  for (std::size_t row = 0; row < frames.size(); ++row) {
    frames.read(row, saved.sample);
    for (const client::AxisSnapshot& axis : saved.sample.axes) {
      if (axis.tick != saved.sample.tick) {
        throw recording::RecordingError("the sample " + std::to_string(row) + " has the tick " +
                                        std::to_string(saved.sample.tick) + ", and its axis " +
                                        to_string(axis.id) + " the tick " +
                                        std::to_string(axis.tick));
      }
      order.note(axis.id, axis.tick);
    }
  }
}

/// @throws recording::RecordingError
void write_samples(const std::string& path, const FrameView& frames, Saved& saved) {
  const auto writer = recording::open_recording(path, VDRIVE_VERSION);
  writer->begin({saved.bench});
  recording::Summary summary;
  for (std::size_t row = 0; row < frames.size(); ++row) {
    frames.read(row, saved.sample);
    ++summary.samples;
    summary.gaps.note_sample(saved.sample);
    writer->status(saved.sample);
  }
  writer->finish(summary);
}

/// @return the message of the exception of `call`, empty if there was none. Runs without the
///         interpreter lock.
template <typename Call>
std::string problem_of(const Call& call) {
  const Unlocked unlocked;
  try {
    call();
  } catch (const recording::RecordingError& error) {
    return error.what();
  }
  return {};
}

void write_recording(const std::string& path, const std::vector<std::string>& axes,
                     const std::vector<std::string>& names, std::optional<std::int64_t> period,
                     const py::array& frames) {
  const auto format = recording::format_of(path);
  if (!format) throw py::value_error("the file name must end in .csv, .jsonl or .mcap");
  Saved saved = saved_of(axes, names, period);
  const FrameView view(frames, axes.size());
  if (axes.empty() || view.size() == 0) throw py::value_error("the recording has no sample");
  if (*format == recording::Format::mcap && !saved.has_period) {
    throw py::value_error(
        ".mcap needs the period of a tick, which the recording does not contain: set its period, "
        "in s");
  }
  const std::string refusal = problem_of([&] {
    check_samples(view, saved);
  });
  if (!refusal.empty()) throw py::value_error(refusal);
  const std::string problem = problem_of([&] {
    write_samples(path, view, saved);
  });
  if (problem.empty()) return;
  PyErr_SetString(PyExc_OSError, problem.c_str());
  throw py::error_already_set();
}

}  // namespace

void add_recording(py::module_& module) {
  module.def("write_recording", &write_recording);
  module.def("read_recording", &read_recording);
}

}  // namespace vdrive::python

// SPDX-License-Identifier: Apache-2.0
#include "convert.hpp"

#include "mcap_recording.hpp"
#include "output_file.hpp"
#include "text_recording.hpp"
#include "vdrive/text.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <exception>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

namespace vdrive::recording {
namespace {

Format format_or_refuse(const std::string& file) {
  const auto format = format_of(file);
  if (!format) throw RecordingError(in_quotes(file) + " does not end in .csv, .jsonl or .mcap");
  return *format;
}

}  // namespace

std::unique_ptr<Writer> open_recording(const std::string& file, const std::string& version) {
  const Format format = format_or_refuse(file);
  auto output = std::make_unique<OutputFile>(file);
  if (format == Format::mcap) return std::make_unique<McapRecording>(std::move(output), version);
  return std::make_unique<TextRecording>(std::move(output), format);
}

Contents read_recording(const std::string& file, const SampleHandler& handler) {
  const Format format = format_or_refuse(file);
  const std::string cannot = "cannot read " + in_quotes(file) + ": ";

  struct stat state {};

  if (::stat(file.c_str(), &state) != 0) {
    throw RecordingError(cannot + std::generic_category().message(errno));
  }
  if (!S_ISREG(state.st_mode)) throw RecordingError(cannot + "it is not a regular file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw RecordingError(cannot + std::generic_category().message(errno));
  std::exception_ptr of_handler;
  const SampleHandler handle = [&](const client::Observation& sample) {
    try {
      handler(sample);
    } catch (...) {
      of_handler = std::current_exception();
      throw;
    }
  };
  try {
    return format == Format::mcap ? read_mcap(stream, handle) : read_text(stream, format, handle);
  } catch (const RecordingError& error) {
    // The handler writes another file: its error must not be reported as one of this file.
    if (of_handler) std::rethrow_exception(of_handler);
    throw RecordingError(cannot + error.what());
  }
}

Contents convert(const ConvertOptions& options) {
  (void)format_or_refuse(options.to);
  std::error_code error;
  if (std::filesystem::equivalent(options.from, options.to, error)) {
    throw RecordingError(in_quotes(options.from) + " and " + in_quotes(options.to) +
                         " are the same file");
  }
  Contents contents = read_recording(options.from, [](const client::Observation&) {});
  for (RecordedBench& bench : contents.benches) {
    if (options.period) bench.period = *options.period;
    name_topics(bench);
  }
  const auto writer = open_recording(options.to, options.version);
  writer->begin(contents.benches);
  Summary summary;
  (void)read_recording(options.from, [&](const client::Observation& sample) {
    ++summary.samples;
    summary.gaps.note_sample(sample);
    writer->status(sample);
  });
  writer->finish(summary);
  return contents;
}

}  // namespace vdrive::recording

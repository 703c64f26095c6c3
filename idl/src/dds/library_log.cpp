// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/library_log.hpp"

#include <fastdds/dds/log/Log.hpp>

#include <memory>
#include <utility>

namespace vdrive::wire {
namespace {

namespace dds = eprosima::fastdds::dds;

class Consumer final : public dds::LogConsumer {
 public:
  explicit Consumer(LibraryLog::Sink sink) : sink_(std::move(sink)) {}

  void Consume(const dds::Log::Entry& entry) override {
    sink_(entry.context.category, entry.message);
  }

 private:
  LibraryLog::Sink sink_;
};

}  // namespace

LibraryLog::LibraryLog(Sink sink) {
  dds::Log::ClearConsumers();
  dds::Log::RegisterConsumer(std::make_unique<Consumer>(std::move(sink)));
}

LibraryLog::~LibraryLog() {
  dds::Log::ClearConsumers();
}

}  // namespace vdrive::wire

/// @file  `DdsRepeater`: says samples again, byte for byte. Fast DDS stays behind it.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "gateway/bus/dds_config.hpp"

namespace motionlab::bus {

/// One DDS participant that only writes what it is given, in the quality of service of each topic. It knows
/// nothing of what the samples say: whoever owns it sees to it that nobody is there who would act on them.
class DdsRepeater {
 public:
  /// @param topics  rows of `kTopicList`
  /// @throws StartupError  as DdsBus
  DdsRepeater(const DdsConfig& config, const std::vector<std::size_t>& topics);
  /// Waits, for a second a topic at most, until reliable readers have what was said.
  ~DdsRepeater();
  DdsRepeater(const DdsRepeater&) = delete;
  DdsRepeater& operator=(const DdsRepeater&) = delete;

  /// One thread. @param cdr  encapsulation header first
  /// @returns false when the bytes are no sample of the topic, the topic is none of those chosen, or DDS does
  /// not take it
  bool say(std::size_t topic, std::span<const std::byte> cdr);

  /// Readers that match our writer of this topic now. Any thread.
  [[nodiscard]] std::size_t readers(std::size_t topic) const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace motionlab::bus

/// @file  `DdsTap`: looks on at every topic and hands over the bytes as they came. Fast DDS stays behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "gateway/bus/dds_bus.hpp"

namespace motionlab::bus {

/// One sample. The views hold during the call that hands it over.
struct TappedSample {
  std::size_t topic = 0;           ///< its row in `kTopicList`
  std::string_view instance;       ///< values of the key fields with '/' between them; empty without a key
  std::span<const std::byte> cdr;  ///< encapsulation header first, not re-encoded
};

/// One DDS participant that only reads: all topics, those of the truth when `join_truth` is set. It has no
/// thread; samples wait in DDS (32 of each instance, the newest stay) until they are taken.
///
/// What arrives is checked as `DdsBus` checks it; what is refused is counted and not handed over, so that
/// nobody behind this meets bytes that are no sample of their type.
class DdsTap {
 public:
  /// @throws StartupError  as DdsBus
  explicit DdsTap(const DdsConfig& config);
  ~DdsTap();
  DdsTap(const DdsTap&) = delete;
  DdsTap& operator=(const DdsTap&) = delete;

  /// Hands over what has arrived, of each topic in order. One thread.
  /// @returns how many samples
  std::size_t take(const std::function<void(const TappedSample&)>& use);

  /// Writers that match this row of `kTopicList` now. Any thread.
  [[nodiscard]] std::size_t writers(std::size_t topic) const noexcept;
  [[nodiscard]] std::uint64_t refused() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace motionlab::bus

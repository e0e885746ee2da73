/// @file  `DdsTap`: looks on at every topic and hands over the bytes as they came. Fast DDS stays behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "gateway/bus/dds_config.hpp"
#include "gateway/bus/dds_id.hpp"

namespace motionlab::bus {

/// One sample. The views hold during the call that hands it over.
struct TappedSample {
  std::size_t topic = 0;           ///< its row in `kTopicList`
  std::string_view instance;       ///< values of the key fields with '/' between them; empty without a key
  std::span<const std::byte> cdr;  ///< encapsulation header first, not re-encoded
  DdsId writer;
  std::uint64_t writer_sequence = 0;  ///< +1 per sample of this writer, over all instances
  std::int64_t t_written_ns = 0;      ///< DDS source timestamp, system clock of the writer's host
  std::int64_t t_heard_ns = 0;        ///< DDS reception timestamp, system clock of this host
};

/// What is looked at, and how patiently.
struct TapOptions {
  std::vector<std::size_t> topics;  ///< rows of `kTopicList`; empty: all of them
  int depth = 32;                   ///< samples of each instance that wait in DDS; the newest stay
};

/// One DDS participant that only reads, topics of the truth only when `join_truth` is set. It has no thread;
/// samples wait in DDS until they are taken.
///
/// What arrives is checked as `DdsBus` checks it; what is refused is counted and not handed over, so that
/// nobody behind this meets bytes that are no sample of their type.
class DdsTap {
 public:
  /// @throws StartupError  as DdsBus
  explicit DdsTap(const DdsConfig& config, const TapOptions& options = {});
  ~DdsTap();
  DdsTap(const DdsTap&) = delete;
  DdsTap& operator=(const DdsTap&) = delete;

  /// Hands over what has arrived, of each topic in order. One thread.
  /// @returns how many samples
  std::size_t take(const std::function<void(const TappedSample&)>& use);

  /// Writers that match this row of `kTopicList` now. Any thread.
  [[nodiscard]] std::size_t writers(std::size_t topic) const noexcept;
  /// Samples of this row that were none of its type. Any thread.
  [[nodiscard]] std::uint64_t refused(std::size_t topic) const noexcept;
  [[nodiscard]] std::uint64_t refused() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace motionlab::bus

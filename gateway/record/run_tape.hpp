/// @file  What the control thread says of each of its steps, handed over to whoever writes it down.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "drivers/core/bytes.hpp"
#include "gateway/bus/topics.hpp"
#include "gateway/record/byte_ring.hpp"
#include "gateway/record/cdr.hpp"
#include "gateway/record/crc32.hpp"
#include "idl/snapshot.hpp"

namespace motionlab::record {

/// What a run's recording has: the inputs of each step, and what it published.
using RunTypes = std::tuple<topic::Snapshot, topic::Estimate, topic::Control, topic::ArmCommand,
                            topic::WinchCommand, topic::Mode, topic::Event>;

/// Place of a type among the RunTypes.
using RunKind = std::uint8_t;
inline constexpr std::size_t kRunKinds = std::tuple_size_v<RunTypes>;

template <class T, RunKind K = 0>
[[nodiscard]] consteval RunKind run_kind() {
  if constexpr (std::is_same_v<T, std::tuple_element_t<K, RunTypes>>) {
    return K;
  } else {
    return run_kind<T, K + 1>();
  }
}

template <class T>
[[nodiscard]] constexpr std::string_view run_topic() {
  if constexpr (std::is_same_v<T, topic::Snapshot>) {
    return "motionlab/snapshot";
  } else {
    return bus::TopicTraits<T>::name;
  }
}

/// Calls f.operator()<T>() for the type of this kind.
template <class F, std::size_t... K>
void for_run_type(RunKind kind, F&& f, std::index_sequence<K...>) {
  ((kind == K ? f.template operator()<std::tuple_element_t<K, RunTypes>>() : void()), ...);
}
template <class F>
void for_run_type(RunKind kind, F&& f) {
  for_run_type(kind, std::forward<F>(f), std::make_index_sequence<kRunKinds>{});
}

/// Published less than once a step: each sample is kept, however few of the others are.
template <class T>
inline constexpr bool kIsRare =
    std::is_same_v<T, topic::Snapshot> || std::is_same_v<T, topic::Mode> || std::is_same_v<T, topic::Event>;

/// Takes from a sample what a stopwatch measured: it cannot come back in a replay.
template <class T>
void without_stopwatch(T& sample) {
  if constexpr (std::is_same_v<T, topic::Control>) sample.step_time_us = sample.step_cpu_us = 0;
}

/// One step as it lies in the ring: this, then its samples, each a SampleHead and its CDR.
struct StepHead {
  std::uint64_t step;  ///< from 1
  std::int64_t t_ns;
  std::uint64_t lost;  ///< steps that found no room, up to this one
};
struct SampleHead {
  std::uint32_t kind;
  std::uint32_t size;
};

/// The control thread's side: `begin`, `add` what is published, `end`; allocates nothing, locks nothing,
/// waits for nobody. A step goes into the ring whole or is counted as lost. The other side takes steps from
/// `ring()`.
class RunTape {
 public:
  /// Room for about three seconds at 1 kHz.
  static constexpr std::size_t kCapacity = 4 * 1024 * 1024;
  /// A step whose inputs are full has 57 KiB.
  static constexpr std::size_t kLargestStep = 96 * 1024;

  /// @param outputs_every  what is published at every step is kept of every so many steps only; the checksum
  /// is of all. @param capacity  in bytes
  explicit RunTape(std::uint32_t outputs_every = 1, std::size_t capacity = kCapacity)
      : outputs_every_(outputs_every), step_(kLargestStep), sample_(kLargestStep), ring_(capacity) {}

  void begin(const topic::Snapshot& inputs) noexcept {
    head_ = {inputs.sequence_number, inputs.t_ns, lost_.load(std::memory_order_relaxed)};
    used_ = sizeof(StepHead);
    fits_ = true;
    outputs_crc_ = 0;
    keep(inputs);
  }

  template <class T>
  void add(const T& sample) noexcept {
    T comparable = sample;
    without_stopwatch(comparable);
    const std::size_t size = write_cdr(comparable, sample_);
    outputs_crc_ = crc32(Bytes{sample_}.first(size), outputs_crc_);
    if (kIsRare<T> || (head_.step - 1) % outputs_every_ == 0) keep(sample);
  }

  void end() noexcept {
    std::memcpy(step_.data(), &head_, sizeof head_);
    if (!fits_ || !ring_.push(Bytes{step_}.first(used_))) lost_.fetch_add(1, std::memory_order_relaxed);
  }

  /// Of everything that the step published, without what a stopwatch measured.
  [[nodiscard]] std::uint32_t outputs_crc() const noexcept { return outputs_crc_; }
  [[nodiscard]] std::uint32_t outputs_every() const noexcept { return outputs_every_; }
  /// Steps that found no room. Any thread.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }
  /// For one consumer.
  [[nodiscard]] ByteRing& ring() noexcept { return ring_; }

 private:
  template <class T>
  void keep(const T& sample) noexcept {
    const std::size_t at = used_ + sizeof(SampleHead);
    if (!fits_ || at > step_.size()) {
      fits_ = false;
      return;
    }
    const std::size_t size = write_cdr(sample, MutableBytes{step_}.subspan(at));
    const SampleHead head{run_kind<T>(), static_cast<std::uint32_t>(size)};
    std::memcpy(step_.data() + used_, &head, sizeof head);
    used_ = at + size;
    fits_ = size > 0;
  }

  std::uint32_t outputs_every_;
  ByteBuffer step_;    ///< the one that is being put together
  ByteBuffer sample_;  ///< for the checksum
  std::size_t used_ = 0;
  bool fits_ = true;
  StepHead head_{};
  std::uint32_t outputs_crc_ = 0;
  std::atomic<std::uint64_t> lost_{0};
  ByteRing ring_;
};

/// Takes one step apart that came out of the ring: calls f(kind, CDR) for each of its samples.
template <class F>
StepHead for_each_sample(Bytes step, F&& f) {
  StepHead head;
  std::memcpy(&head, step.data(), sizeof head);
  std::size_t at = sizeof head;
  while (at < step.size()) {
    SampleHead sample;
    std::memcpy(&sample, step.data() + at, sizeof sample);
    at += sizeof sample;
    f(static_cast<RunKind>(sample.kind), step.subspan(at, sample.size));
    at += sample.size;
  }
  return head;
}

}  // namespace motionlab::record

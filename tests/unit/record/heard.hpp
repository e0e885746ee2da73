/// @file  Samples as a tap hands them over, for those who record them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gateway/bus/dds_tap.hpp"
#include "gateway/bus/topic_list.hpp"
#include "gateway/record/cdr.hpp"

namespace motionlab::record {

/// Owns the bytes that its sample shows.
class Heard {
 public:
  template <class T>
  Heard(const T& sample, std::uint64_t sequence, std::int64_t t_ns, std::uint8_t writer = 1)
      : topic_(bus::topic_index<T>()), sequence_(sequence), t_ns_(t_ns), cdr_(64 * 1024) {
    cdr_.resize(write_cdr(sample, cdr_));
    writer_.bytes[0] = writer;
  }

  [[nodiscard]] bus::TappedSample sample() const {
    return {.topic = topic_,
            .instance = {},
            .cdr = std::as_bytes(std::span{cdr_}),
            .writer = writer_,
            .writer_sequence = sequence_,
            .t_written_ns = t_ns_ - 1000,
            .t_heard_ns = t_ns_};
  }

 private:
  std::size_t topic_;
  std::uint64_t sequence_;
  std::int64_t t_ns_;
  ByteBuffer cdr_;
  bus::DdsId writer_;
};

}  // namespace motionlab::record

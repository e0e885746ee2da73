/// @file  Hears a topic whose type is known only at run time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "gateway/bus/dds_watch.hpp"
#include "gateway/monitor/topic_table.hpp"

namespace motionlab::monitor {

/// A sample of any topic, as it was heard.
struct HeardSample {
  Values values;  ///< in the order of the topic's description
  std::string
      instance;  ///< "mru1", "qualisys/load"; empty for a topic without keys. From the bus: not to be trusted
  bus::Refusal refusal = bus::Refusal::none;  ///< else the values are not to be believed
  bool data = true;                           ///< false: only a sign that a writer or an instance has left
  bus::DdsId writer;
  std::uint64_t writer_sequence = 0;
  std::int64_t t_written_ns = 0;  ///< DDS source timestamp, system clock of the writer's host
  std::int64_t t_heard_ns = 0;    ///< DDS reception timestamp, system clock of this host
};

class AnyTap {
 public:
  virtual ~AnyTap() = default;
  [[nodiscard]] virtual std::optional<HeardSample> next() = 0;
  /// Samples that were not asked for in time and are missing here.
  [[nodiscard]] virtual std::uint64_t overflowed() const = 0;
};

/// Hears the topic of this name with the type of `description` from now on.
/// @param description  one of `every_topic()`
/// @throws StartupError  DDS refuses the topic
[[nodiscard]] std::unique_ptr<AnyTap> tap(bus::DdsWatch& watch, const TopicDescription& description,
                                          const std::string& name);

}  // namespace motionlab::monitor

/// @file  The values of a recorded sample of any topic.
#pragma once

#include <optional>

#include "drivers/core/bytes.hpp"
#include "gateway/monitor/topic_table.hpp"

namespace motionlab::monitor {

/// Nothing when the bytes are no little-endian CDR of the type.
using Decoder = std::optional<Values> (*)(Bytes cdr);

/// @param topic  one of `every_topic()`
[[nodiscard]] Decoder decoder_of(const TopicDescription& topic);

}  // namespace motionlab::monitor

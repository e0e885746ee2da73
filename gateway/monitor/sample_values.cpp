#include "gateway/monitor/sample_values.hpp"

#include "gateway/record/cdr.hpp"

namespace motionlab::monitor {
namespace {

template <class T>
std::optional<Values> decode(Bytes cdr) {
  T sample;
  if (!record::read_cdr(cdr, sample, record::kDdsPadding)) return std::nullopt;
  return values_of(sample);
}

}  // namespace

Decoder decoder_of(const TopicDescription& topic) {
#define MOTIONLAB_DECODER(Type) \
  if (topic.type == topic::Type::kTypeName) return decode<topic::Type>;
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_DECODER)
#undef MOTIONLAB_DECODER
  return [](Bytes) -> std::optional<Values> { return std::nullopt; };
}

}  // namespace motionlab::monitor

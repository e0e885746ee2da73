#include "gateway/monitor/any_tap.hpp"

#include <utility>

#include "drivers/core/error.hpp"

namespace motionlab::monitor {
namespace {

template <class T>
class TapOf final : public AnyTap {
 public:
  TapOf(bus::DdsWatch& watch, const std::string& topic) : tap_{watch.hear<T>(topic)} {}

  std::optional<HeardSample> next() override {
    const std::optional<bus::Heard<T>> heard = tap_.next();
    if (!heard) return std::nullopt;
    return HeardSample{.values = values_of(heard->sample),
                       .instance = instance_of(heard->sample),
                       .refusal = heard->refusal,
                       .data = heard->data,
                       .writer = heard->writer,
                       .writer_sequence = heard->writer_sequence,
                       .t_written_ns = heard->t_written_ns,
                       .t_heard_ns = heard->t_heard_ns};
  }

  [[nodiscard]] std::uint64_t overflowed() const override { return tap_.overflowed(); }

 private:
  bus::DdsWatch::Tap<T> tap_;
};

}  // namespace

std::unique_ptr<AnyTap> tap(bus::DdsWatch& watch, const TopicDescription& description,
                            const std::string& name) {
#define MOTIONLAB_TAP(Type) \
  if (description.type == topic::Type::kTypeName) return std::make_unique<TapOf<topic::Type>>(watch, name);
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_TAP)
#undef MOTIONLAB_TAP
  throw StartupError{"the type " + std::string{description.type} + " is none of the house"};
}

}  // namespace motionlab::monitor

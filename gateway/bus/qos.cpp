#include "gateway/bus/qos.hpp"

#include <algorithm>

namespace motionlab::bus {
namespace {

namespace fast = eprosima::fastdds::dds;
using eprosima::fastrtps::Duration_t;

constexpr int kStateReaderDepth = 16;

int depth_of(QosClass qos) {
  return qos == QosClass::event ? 100 : qos == QosClass::request ? 16 : 1;
}

// What writer and reader of a class have in common.
template <class Qos>
void set_common(const TopicShape& shape, int depth, int instances, Qos& qos) {
  const bool reliable = shape.qos != QosClass::sensor;
  const bool kept = shape.qos == QosClass::state || shape.qos == QosClass::event;

  qos.reliability().kind = reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = kept ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  // The default allows ten instances: the eleventh would vanish without a word.
  qos.resource_limits().max_instances = instances;
  qos.resource_limits().max_samples_per_instance = depth;
  qos.resource_limits().max_samples = instances * depth;
  qos.resource_limits().allocated_samples = kMaxWrittenInstances;
  qos.ownership().kind = fast::SHARED_OWNERSHIP_QOS;
  qos.data_sharing().off();  // its segments would outlive a killed process
  if (shape.qos == QosClass::sensor && shape.period_s > 0) {
    qos.deadline().period = Duration_t{static_cast<long double>(kDeadlinePeriods * shape.period_s)};
  }
  if (shape.qos == QosClass::command) {
    // The automatic kinds never report a dead writer while another one in the same process lives.
    qos.liveliness().kind = fast::MANUAL_BY_TOPIC_LIVELINESS_QOS;
    qos.liveliness().lease_duration = Duration_t{static_cast<long double>(seconds(kCommandLiveliness))};
    qos.lifespan().duration = Duration_t{static_cast<long double>(seconds(kCommandLifespan))};
  }
}

}  // namespace

fast::DataWriterQos writer_qos(const TopicShape& shape) {
  fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
  set_common(shape, depth_of(shape.qos), kMaxWrittenInstances, qos);
  qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_MEMORY_MODE;
  if (shape.qos == QosClass::command) {
    qos.liveliness().announcement_period =
        Duration_t{static_cast<long double>(seconds(kCommandLiveliness) / 3)};
  }
  // A lost reliable sample is asked for again within a tenth of a second (default: three seconds).
  qos.reliable_writer_qos().times.heartbeatPeriod = Duration_t{0.1L};
  return qos;
}

fast::DataReaderQos reader_qos(const TopicShape& shape) {
  fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
  // A reader's depth is its own affair. A reliable reader of a topic without a key that has room for one
  // sample only has none for the one it waits for while a later one is there already, and starves under a
  // fast writer.
  const int depth = depth_of(shape.qos);
  set_common(shape, shape.qos == QosClass::state ? kStateReaderDepth : depth, kMaxReadInstances, qos);
  // Room for samples that are larger than the type allows: they shall be refused and counted, not vanish.
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return qos;
}

fast::DataReaderQos tap_qos(const TopicShape& shape, int depth) {
  fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
  set_common({shape.qos, 0}, std::max(depth, depth_of(shape.qos)), kMaxReadInstances, qos);
  if (shape.qos ==
      QosClass::command) {  // a reliable reader would cost the writer of commands acknowledgements
    qos.reliability().kind = fast::BEST_EFFORT_RELIABILITY_QOS;
    qos.liveliness() = fast::LivelinessQosPolicy{};
    qos.lifespan() = fast::LifespanQosPolicy{};
  }
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return qos;
}

}  // namespace motionlab::bus

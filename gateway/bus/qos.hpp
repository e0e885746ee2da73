/// @file  The quality-of-service classes of topics.hpp, said in Fast DDS. Seen by dds_bus.cpp alone.
#pragma once

#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "gateway/bus/topics.hpp"

namespace motionlab::bus {

/// What decides a topic's QoS.
struct TopicShape {
  QosClass qos;
  double period_s;
};

[[nodiscard]] eprosima::fastdds::dds::DataWriterQos writer_qos(const TopicShape& shape);
[[nodiscard]] eprosima::fastdds::dds::DataReaderQos reader_qos(const TopicShape& shape);
/// For one who looks on: matches every writer of the class, promises nothing and asks for nothing that a
/// writer would have to do more for. Keeps so many samples of each instance until they are taken.
[[nodiscard]] eprosima::fastdds::dds::DataReaderQos tap_qos(const TopicShape& shape, int depth);

}  // namespace motionlab::bus

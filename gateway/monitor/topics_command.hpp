/// @file  `motionlab topics`: who writes and reads what on the bus, strangers included.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gateway/bus/dds_watch.hpp"
#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct TopicsCommand {
  double wait_s = 2;       ///< discovery has no end; so long is listened
  bool endpoints = false;  ///< show every writer and reader
  bool json = false;
};

/// One topic as it is used on the bus. Endpoints of one name but different types are different rows, for they
/// never match.
struct TopicRow {
  std::string name;
  std::string type;
  bool known = false;  ///< the type is one of this house
  std::vector<bus::SeenEndpoint> writers;
  std::vector<bus::SeenEndpoint> readers;
};

/// In the order of their names. Endpoints of DDS itself and of ROS graphs are shown like all others.
[[nodiscard]] std::vector<TopicRow> rows_of(const std::vector<bus::SeenEndpoint>& endpoints);

/// A table with one line a topic; with `endpoints` also one line for each writer and reader.
[[nodiscard]] std::string topics_text(const std::vector<TopicRow>& rows, bool endpoints);
[[nodiscard]] nlohmann::ordered_json topics_json(const std::vector<TopicRow>& rows,
                                                 const std::vector<bus::SeenParticipant>& participants);

/// @returns kExitGood when anybody is there; kExitNobody otherwise
int run_topics(const Connection& connection, const TopicsCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor

/// @file  Finds the topic that somebody named, on the bus and in the house.
#pragma once

#include <string>
#include <vector>

#include "gateway/monitor/any_tap.hpp"
#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct FoundTopic {
  std::string name;
  const TopicDescription* description = nullptr;  ///< null only when interrupted
};

/// A topic of the house is found at once, whether anybody writes it or not; "mru" means "motionlab/mru" as
/// well. Any other name is looked for on the bus until the connection's timeout: it is found when a writer
/// has a type of the house.
/// @throws StartupError  no such topic, with the nearest name; or its type is not known here
[[nodiscard]] FoundTopic find_topic(bus::DdsWatch& watch, bus::Wakeup& wakeup, const std::string& wanted,
                                    const Connection& connection, const Terminal& terminal);

/// Why nothing is heard: nobody writes the topic, or somebody does, but is silent or writes another encoding.
[[nodiscard]] std::string nothing_heard(const FoundTopic& topic, const bus::DdsWatch& watch,
                                        const Connection& connection, double waited_s);

/// "motionlab-gateway on labhost", harmless on a terminal.
[[nodiscard]] std::string who(const bus::SeenEndpoint& endpoint);

}  // namespace motionlab::monitor

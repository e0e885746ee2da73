#include "gateway/monitor/session.hpp"

#include <pwd.h>
#include <unistd.h>

#include <array>

#include "gateway/monitor/text.hpp"

namespace motionlab::monitor {
bus::DdsConfig dds_config(const Connection& connection, bool join_truth) {
  bus::DdsConfig config;
  config.domain = connection.domain;
  config.interface_whitelist = connection.interfaces;
  config.participant = "motionlab";
  config.join_truth = join_truth;
  config.peers = connection.peers;
  config.server = connection.server;
  config.security = connection.security;
  return config;
}

Session::Session(const Connection& connection, bool join_truth)
    : dds{dds_config(connection, join_truth), local} {}

std::string nobody_answers(const Connection& connection, double waited_s) {
  std::string where = "DDS domain " + std::to_string(connection.domain) + ", ";
  if (connection.interfaces.empty()) {
    where += "any interface";
  } else {
    where += "interface";
    for (const std::string& address : connection.interfaces) where += " " + address;
  }
  for (const std::string& peer : connection.peers) where += ", peer " + peer;
  if (!connection.server.empty()) where += ", by the discovery server " + connection.server;
  if (!connection.security.empty()) where += ", with the identity in " + connection.security;
  return "nobody answers on " + where + " within " + fixed(waited_s, 1) +
         " s: is motionlab-gateway running, and in this domain and on this network? (--domain, --interface; "
         "a gateway started by lab.sh is at --interface 127.0.0.1)";
}

std::string requester_name() {
  const passwd* const user = getpwuid(getuid());
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  return (user ? std::string{user->pw_name} : std::to_string(getuid())) + "@" + host.data();
}

}  // namespace motionlab::monitor

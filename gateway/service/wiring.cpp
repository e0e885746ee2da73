#include "gateway/service/wiring.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>
#include <vector>

namespace motionlab::service {
namespace {

constexpr std::string_view kTitle = "─ motionlab-gateway ─";
constexpr std::size_t kTitleWidth = 21;  // on the screen
constexpr std::string_view kIn = "──udp─▶", kUdp = "◀─udp─▶", kTcp = "◀─tcp─▶";
constexpr std::size_t kArrowWidth = 7;

/// One arrow of the drawing.
struct Wire {
  std::string device;  ///< empty: of the one above
  std::string there;
  std::string_view arrow;
  std::string here;
};

std::vector<Wire> wires_of(const GatewayConfig& config) {
  std::vector<Wire> wires;
  for (const auto& mru : config.mrus) {
    wires.push_back(
        {mru.driver.device, address_to_string(mru.driver.source_address), kIn, to_string(mru.listen)});
  }
  const auto& cameras = config.qualisys;
  wires.push_back({cameras.driver.device, to_string(cameras.server), kTcp, "any port"});
  wires.push_back({"", address_to_string(cameras.server.address), kIn, to_string(cameras.listen)});
  wires.push_back({config.comau.driver.device, to_string(config.comau.driver.robot_computer), kUdp,
                   to_string(config.comau.listen)});
  wires.push_back({config.winch.driver.device, to_string(config.winch.plc), kTcp, "any port"});
  if (const auto& plc = config.plc_reply)
    wires.push_back({plc->driver.device, to_string(plc->driver.plc), kUdp, to_string(plc->listen)});
  return wires;
}

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

std::string line_of(std::size_t length) {
  std::string line;
  while (length-- > 0) line += "─";
  return line;
}

std::string how_found(const bus::DdsConfig& dds) {
  if (!dds.server.empty()) return "by the discovery server " + dds.server;
  if (dds.peers.empty()) return "by multicast";
  std::string text = "at";
  for (const auto& peer : dds.peers) text += ' ' + peer;
  return text;
}

std::string bus_text(const bus::DdsConfig& dds) {
  std::string interfaces;
  for (const auto& address : dds.interface_whitelist) interfaces += ' ' + address;
  return "DDS domain " + std::to_string(dds.domain) + " on" +
         (interfaces.empty() ? " all interfaces" : interfaces) + ", others are found " + how_found(dds) +
         (dds.security.empty() ? "" : ", protected");
}

}  // namespace

std::string wiring(const GatewayConfig& config) {
  std::ostringstream out;
  const auto line = [&out](const std::string& who, const std::string& what) {
    out << "  " << who << '\t' << what << '\n';
  };
  for (const auto& mru : config.mrus) {
    line(mru.driver.device, "listens on udp " + to_string(mru.listen) + ", hears " +
                                address_to_string(mru.driver.source_address) + " (" +
                                std::string{to_string(mru.driver.format)} + ")" +
                                (mru.rule.required ? ", required" : ""));
  }
  line(config.qualisys.driver.device, "calls tcp " + to_string(config.qualisys.server) +
                                          ", frames come to udp " + to_string(config.qualisys.listen) +
                                          (config.qualisys.rule.required ? ", required" : ""));
  line(config.comau.driver.device, "sends udp from " + to_string(config.comau.listen) + " to " +
                                       to_string(config.comau.driver.robot_computer) + ", required");
  line(config.winch.driver.device, "calls tcp " + to_string(config.winch.plc) + " (ADS " +
                                       winch::to_string(config.winch.driver.target.net_id) + "), required");
  if (const auto& plc = config.plc_reply) {
    line(plc->driver.device, "asks udp " + to_string(plc->driver.plc) + " from " + to_string(plc->listen) +
                                 " for its remote reply, with key 0: it takes no control");
  }
  const auto milliseconds = [](double s) { return std::to_string(std::lround(1e3 * s)) + " ms"; };
  line("deadman",
       "brakes the arm from the same port and settles the winch when the gateway is gone; ends it "
       "first when io is silent for " +
           milliseconds(config.deadman.heartbeat_s) + " or control for " +
           milliseconds(config.deadman.control_s));
  line("bus", bus_text(config.bus));
  for (const auto& note : config.notes) line("note", note);
  return out.str();
}

std::string wiring_drawing(const GatewayConfig& config) {
  const std::vector<Wire> wires = wires_of(config);
  std::size_t device = 0, there = 0, inside = kTitleWidth;
  for (const Wire& wire : wires) {
    device = std::max(device, wire.device.size());
    there = std::max(there, wire.there.size());
    inside = std::max(inside, wire.here.size() + 2);
  }
  const std::string before(2 + device + 2 + there + 2 + kArrowWidth + 1, ' ');
  std::string drawing = before + "┌" + std::string{kTitle} + line_of(inside - kTitleWidth) + "┐\n";
  for (const Wire& wire : wires) {
    drawing += "  " + padded(wire.device, device) + "  " + padded(wire.there, there) + "  " +
               std::string{wire.arrow} + " │ " + padded(wire.here, inside - 1) + "│\n";
  }
  drawing += before + "└──┬" + line_of(inside - 3) + "┘\n";
  return drawing + before + "   └─ " + bus_text(config.bus) + "\n";
}

}  // namespace motionlab::service

#include "gateway/doctor/devices.hpp"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <numeric>

#include "drivers/core/error.hpp"
#include "gateway/monitor/check_command.hpp"
#include "gateway/monitor/text.hpp"

namespace motionlab::doctor {
namespace {

using boost::asio::ip::tcp;
using monitor::fixed;

constexpr std::chrono::seconds kConnectPatience{2};
constexpr double kListen_s = 1.0;
/// Ages beyond this share of their limit are said before they stop a run.
constexpr double kNearlyStale = 0.8;

/// "200.0 Hz, oldest 7.4 of 25.0 ms"; the control thread's own row has no limit of age.
std::string ages(const topic::Health& health) {
  const std::string rate = fixed(health.rate_hz, 1) + " Hz";
  if (health.stale_after_s <= 0) return rate;
  return rate + ", oldest " + fixed(1e3 * health.age_max_s, 1) + " of " +
         fixed(1e3 * health.stale_after_s, 1) + " ms";
}

/// "3 foreign, 1 bad_value"
std::string rejects(const topic::Health& health) {
  std::string text;
  for (std::size_t i = 0; i < health.rejected.size(); ++i) {
    if (health.rejected[i] == 0) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(health.rejected[i]) + ' ';
    text += to_string(static_cast<Reason>(i));
  }
  return text;
}

Finding judge(const topic::Health& health) {
  const std::string subject(health.device.view());
  const std::string advice(health.advice.view());
  if (health.link != topic::LinkState::up) {
    return {health.required ? Grade::fail : Grade::warn, subject, std::string(to_string(health.link)),
            advice.empty() ? "look at its power, its cable and its address" : advice};
  }
  if (!advice.empty()) return {Grade::warn, subject, ages(health), advice};
  if (const std::string rejected = rejects(health); !rejected.empty()) {
    return {Grade::warn, subject, ages(health) + "; rejected since the start: " + rejected,
            "see recover.md for what each reason means"};
  }
  if (health.stale_after_s > 0 && health.age_max_s > kNearlyStale * health.stale_after_s) {
    return {Grade::warn, subject, ages(health) + ": close to letting go",
            "look for what holds this machine or its network up: motionlab delay"};
  }
  return {Grade::pass, subject, ages(health), ""};
}

Finding judge(const topic::Mode& mode) {
  const std::string state(to_string(mode.state));
  const std::string reason(mode.reason.view());
  if (mode.state == topic::ModeState::fault) {
    return {Grade::warn, "mode", state + ": " + reason, "end the cause, then: motionlab reset"};
  }
  if (!mode.fault_code.empty())
    return {Grade::warn, "mode", state + ": " + reason, "recover.md has what to do"};
  return {Grade::pass, "mode", state, ""};
}

Finding listen_for(const service::MruLink& mru, const std::atomic<bool>& interrupted) {
  const std::string& device = mru.driver.device;
  const std::string wanted(mru::to_string(mru.driver.format));
  const std::string port = "udp port " + std::to_string(mru.listen.port);
  const Grade wrong = mru.rule.required ? Grade::fail : Grade::warn;
  try {
    const auto stream =
        monitor::listen_to_mru({.port = mru.listen.port, .seconds = kListen_s, .variables = {}}, interrupted);
    if (stream.detector().datagrams() == 0) {
      return {wrong, device, "nothing comes to " + port,
              "in the unit: send to this host's address and port; look at its power and cable"};
    }
    const auto from = stream.from();
    if (mru.driver.source_address != 0 && from->address != mru.driver.source_address) {
      return {wrong, device,
              "datagrams come from " + to_string(*from) + ", configured is " +
                  address_to_string(mru.driver.source_address),
              "correct [" + device + "] source, or the unit's address"};
    }
    const auto format = stream.detector().format();
    if (format != mru.driver.format) {
      return {wrong, device,
              "it sends " + (format ? std::string(mru::to_string(*format)) : "no known format") +
                  ", configured is " + wanted,
              "motionlab check mru --listen " + std::to_string(mru.listen.port) + " shows what it sends"};
    }
    return {Grade::pass, device,
            wanted + " at " + fixed(stream.rate_hz(), 1) + " Hz from " + to_string(*from), ""};
  } catch (const StartupError& error) {
    return {wrong, device, "cannot be listened to: " + std::string(error.what()), "end who has the port"};
  }
}

/// A connection is opened and closed; not a byte is sent.
Finding knock(const std::string& device, const Endpoint& server, bool required) {
  boost::asio::io_context io;
  tcp::socket socket(io);
  boost::system::error_code refused = boost::asio::error::timed_out;
  socket.async_connect({boost::asio::ip::address_v4(server.address), server.port},
                       [&](const boost::system::error_code& result) { refused = result; });
  io.run_for(kConnectPatience);
  if (!refused) return {Grade::pass, device, "accepts a connection at " + to_string(server), ""};
  return {required ? Grade::fail : Grade::warn, device, to_string(server) + ": " + refused.message(),
          "start it; look at its address, its firewall, its route to this host"};
}

}  // namespace

Findings judge(const monitor::Status& status) {
  Findings say;
  if (status.mode) say.push_back(judge(*status.mode));
  for (const topic::Health& health : status.devices) say.push_back(judge(health));
  return say;
}

Findings look_for_devices(const service::GatewayConfig& config, const std::atomic<bool>& interrupted) {
  Findings say;
  for (const auto& mru : config.mrus) say.push_back(listen_for(mru, interrupted));
  say.push_back(knock(config.qualisys.driver.device, config.qualisys.server, config.qualisys.rule.required));
  say.push_back(knock(config.winch.driver.device, config.winch.plc, config.winch.rule.required));
  say.push_back({Grade::warn, config.comau.driver.device,
                 "not looked at: the robot computer answers only who commands it",
                 "start the gateway, which moves nothing until it is asked to, and call the doctor again"});
  if (config.plc_reply) {
    say.push_back({Grade::warn, config.plc_reply->driver.device,
                   "not looked at: the PLC answers only who asks it",
                   "start the gateway, and call the doctor again"});
  }
  return say;
}

}  // namespace motionlab::doctor

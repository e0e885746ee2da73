/// @file  Arm and winch brought to rest on their real wires, by whoever is left.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "drivers/comau/comau_driver.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/time.hpp"
#include "drivers/winch/winch_driver.hpp"
#include "gateway/deadman/brake_sequence.hpp"
#include "gateway/deadman/winch_settler.hpp"

namespace motionlab::deadman {

/// Where the wires are and how to brake on them: the gateway's own settings.
struct WireConfig {
  Endpoint listen;  ///< the gateway's port: a careful robot computer hears no other
  comau::DriverConfig arm;
  std::optional<double> robot_brakes_after_s;
  Endpoint plc;
  winch::DriverConfig winch;
};

/// How it ended.
struct Outcome {
  BrakeSequence::End arm = BrakeSequence::End::not_yet;
  WinchSettler::End winch = WinchSettler::End::not_yet;

  /// Both are known to be at rest, or there was nothing to settle.
  [[nodiscard]] bool settled() const noexcept;
  /// For people; says what to do where something is not at rest.
  [[nodiscard]] std::string text(const WireConfig& config) const;
};

/// The sockets, the brake and the winch's driver on the calling thread.
///
/// Nothing is opened before `open`. The arm comes first: its first datagram leaves within `begin`, before the
/// winch is called.
class Settlement {
 public:
  /// @param clock  outlives this
  Settlement(const WireConfig& config, const Clock& clock);
  ~Settlement();
  Settlement(const Settlement&) = delete;
  Settlement& operator=(const Settlement&) = delete;

  /// Takes a local port for the arm. @throws StartupError when it is not to be had
  void open(Endpoint local);
  /// Sends the first datagram. @param last  what was said to the robot computer last, if that is known
  void begin(const std::optional<Said>& last);
  /// Goes on until arm and winch have ended.
  Outcome finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace motionlab::deadman

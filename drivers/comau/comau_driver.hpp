/// @file  Sends joint velocities to the robot computer on a timer and tells where the joints are.
#pragma once

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>

#include "drivers/comau/comau_driver_posture.hpp"
#include "drivers/comau/comau_driver_response.hpp"
#include "drivers/comau/comau_driver_velocity.hpp"
#include "drivers/comau/comau_wire.hpp"
#include "drivers/core/bytes.hpp"
#include "drivers/core/device_clock.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/link_health.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/sink.hpp"
#include "drivers/core/time.hpp"
#include "drivers/core/wrapping_counter.hpp"
#include "idl/arm_command.hpp"
#include "idl/arm_state.hpp"

namespace motionlab::comau {

/// The defaults of the box and of the speeds are the laboratory's settings file, as published.
struct DriverConfig {
  std::string device = "arm";  ///< name on the topics
  Endpoint robot_computer{};   ///< commands go there; answers are taken from there alone (port 0: any port)
  double command_period_s = 0.005;
  double command_stale_after_s = 0.025;  ///< a follow command older than this is not sent any more
  double answer_stale_after_s = 0.025;   ///< nothing moves on a measurement older than this

  // The driver's own limits, kept whatever is commanded (see VelocityShaper).
  Joints q_min_rad{-std::numbers::pi / 4,  -std::numbers::pi / 6,  -std::numbers::pi * 3 / 4,
                   -std::numbers::pi / 18, -std::numbers::pi / 18, -std::numbers::pi / 18};
  Joints q_max_rad{std::numbers::pi / 4,  std::numbers::pi / 6,  -std::numbers::pi / 4,
                   std::numbers::pi / 18, std::numbers::pi / 18, std::numbers::pi / 18};
  Joints qd_max_radps{std::numbers::pi / 6,  std::numbers::pi / 6,  std::numbers::pi / 6,
                      std::numbers::pi / 60, std::numbers::pi / 60, std::numbers::pi / 60};
  Joints qdd_max_radps2{6.0, 6.0, 6.0, 1.2, 1.2, 1.2};
  Joints stop_deceleration_radps2{1.0, 1.0, 1.0, 3.0, 3.0, 3.0};

  double rest_before_motion_s = 0.02;  ///< mode 1 begins with zero speed for so long
  double rest_before_hold_s = 0.1;     ///< mode 1 with zero speed is kept so long, for the arm to catch up
  double latency_s = 0.0;              ///< constant part of the delay from measurement to arrival
  double drift_ppm_max = 200.0;        ///< fastest drift of the robot computer's cycle that is followed
  int frozen_after_answers = 4;  ///< so many answers with one frame counter: its control cycle stands still
  double silent_after_s = 1.0;   ///< without a new frame for so long the link is down
  double ignored_after_s = 0.2;  ///< told to move and not moving for so long: braked, and said in the advice
  double answer_gap_s = 0.02;    ///< across a longer gap between answers nothing is said of how the arm moves
  double slow_below_share = 0.85;  ///< moving at less than this share of what is told: said in the advice
  double ahead_unasked_s = 0.01;   ///< the counter runs ahead of our time by more: asked of the next answer
  double restart_gap_s = 1.0;      ///< the frame counter jumps by more than this: the program was restarted
  int farewell_datagrams = 20;     ///< mode 0 at the end of an orderly stop
};

/// The shaper that these settings ask for: the one way of this house to speed up and to brake the arm.
[[nodiscard]] VelocityShaper::Config shaper_config(const DriverConfig& config);

/// Our end of the exchange with the robot computer.
///
/// The robot computer answers each datagram, sends nothing by itself, has no time-out and integrates the last
/// velocity for ever. Hence: commands leave in `step` on an absolute schedule of `command_period_s`, never on
/// receipt, from the first step on. The first are mode 0 with zero speed, and so are all until somebody wants
/// to follow. A slot that was missed (the host stood still) is skipped, not made up.
///
/// While following, the newest command is sent, kept within speed, acceleration and stopping distance by the
/// driver's own limits. The driver brakes by itself, each joint with its stop deceleration per command
/// period, when
///   - the newest command says hold, or an orderly stop was asked for;
///   - the newest command is older than `command_stale_after_s` (counted, advice);
///   - a wanted velocity is not finite (counted as bad_value; such a number never leaves);
///   - the robot computer's frame counter stands still, or the newest measurement is older than
///     `answer_stale_after_s`, or there is none yet (advice);
///   - the arm is told to move and does not (advice): drives off, program held, or not in remote mode. That
///     one lasts until somebody says hold: whoever presses START must not set the arm in motion by it.
/// Mode 1 begins and ends at rest; mode 0 makes the robot computer take its set point from where the arm is.
/// When the cause of another brake that nobody asked for is gone, the driver goes back to the wanted velocity
/// within the same limits. Whether motion may be resumed at all is not decided here but by the guard.
///
/// Answers are taken in both forms. Refused and counted: foreign senders, wrong sizes, values that are not
/// finite or that the arm cannot have (bad_value), a frame counter that has not moved (duplicate) or is older
/// (out_of_order); one that has jumped is taken for a restart of the program when the next answer goes on
/// from there, and is `unexpected` until then. The counter runs at 2500/s and dates each measurement.
class ComauDriver {
 public:
  /// @param on_sent  optional: every command that really left, with the time as `t_created_ns`
  ComauDriver(DriverConfig config, DatagramOut& out, Sink<topic::ArmState> on_state,
              Sink<topic::ArmCommand> on_sent = {});

  /// Stores the newest command; its age counts from `t_created_ns`. A follow command that was created before
  /// the one stored is refused (out_of_order); hold is taken always.
  void set_command(const topic::ArmCommand& command);
  void on_datagram(Bytes datagram, Endpoint from, LabTime t_received);
  /// Sends what is due. Call at `next_send()`, or about every millisecond.
  void step(LabTime now);
  /// When the next command is due: in the past before the first step, `LabTime::max()` when stopped.
  [[nodiscard]] LabTime next_send() const noexcept { return next_send_; }

  /// Ramps to rest, then sends the farewell datagrams of mode 0, then nothing more. Cannot be taken back.
  void orderly_stop() noexcept { stopping_ = true; }
  /// The last farewell datagram has left.
  [[nodiscard]] bool stopped() const noexcept { return stopped_; }

  [[nodiscard]] const LinkHealth& health() const noexcept { return health_; }
  /// What the robot computer was really told last; nothing before the first.
  [[nodiscard]] const std::optional<Command>& last_sent() const noexcept { return last_sent_; }
  [[nodiscard]] std::optional<LabTime> t_last_sent() const noexcept { return t_last_sent_; }
  [[nodiscard]] std::uint64_t sent() const noexcept { return sent_; }
  /// How often a wanted motion became too old while following.
  [[nodiscard]] std::uint64_t stale_commands() const noexcept { return stale_commands_; }
  /// Slots of the schedule in which nothing left because `step` came too late.
  [[nodiscard]] std::uint64_t missed_slots() const noexcept { return missed_slots_; }
  /// False while the frame counter stands still or the newest measurement is too old; false before the first.
  [[nodiscard]] bool feedback_fresh(LabTime now) const noexcept;
  /// Laboratory time minus the robot computer's time in use; 0 before the first answer.
  [[nodiscard]] double clock_offset_s() const noexcept { return clock_.offset_s(); }
  [[nodiscard]] double clock_drift_ppm() const noexcept { return clock_.drift_ppm(); }

 private:
  enum class Brake : std::uint8_t { none, hold, stale, not_finite, frozen, blind, ignored };
  /// A frame counter that does not follow from the one before.
  struct Jump {
    std::uint32_t frame_counter = 0;
    LabTime t_received{};
  };

  void send_slot(LabTime now);
  /// @returns whether it left
  bool send(const Command& command, LabTime now);
  [[nodiscard]] Brake why_brake(LabTime now) const noexcept;
  [[nodiscard]] bool silent(LabTime now) const noexcept;
  void keep_schedule(LabTime now) noexcept;
  [[nodiscard]] std::string_view advice(LabTime now) const noexcept;
  [[nodiscard]] bool blind(LabTime now) const noexcept;
  void refuse(Fault fault, LabTime t_received) noexcept;
  [[nodiscard]] Result<WrappingCounter::Step> judge_counter(std::uint32_t frame_counter,
                                                            LabTime t_received) noexcept;
  [[nodiscard]] Nanoseconds passed_since_last(const Answer& answer, WrappingCounter::Step step,
                                              LabTime t_received) const noexcept;
  [[nodiscard]] LabTime place_in_time(const Answer& answer, WrappingCounter::Step step,
                                      LabTime t_received) noexcept;
  void watch_response(const Answer& answer, Nanoseconds passed) noexcept;
  void note_limits(const Answer& answer) noexcept;

  DriverConfig config_;
  DatagramOut& out_;
  Sink<topic::ArmState> on_state_;
  Sink<topic::ArmCommand> on_sent_;
  LinkHealth health_;

  // What is wanted and what is said.
  std::optional<topic::ArmCommand> wanted_;
  VelocityShaper shaper_;
  Brake brake_ = Brake::hold;
  bool stopping_ = false;
  bool stopped_ = false;
  int farewells_ = 0;

  // The schedule.
  std::optional<LabTime> t_started_;
  LabTime next_send_ = LabTime::min();
  std::optional<Command> last_sent_;
  std::optional<LabTime> t_last_sent_;
  std::uint64_t sent_ = 0;
  std::uint64_t stale_commands_ = 0;
  std::uint64_t missed_slots_ = 0;

  // What comes back.
  DeviceClock clock_;
  WrappingCounter frames_;
  std::uint64_t sent_at_last_frame_ = 0;
  int unchanged_answers_ = 0;
  std::optional<LabTime> t_refused_;
  std::optional<Jump> jump_;
  PostureCheck posture_;
  ResponseWatch response_;
  bool ignored_ = false;  ///< it was told to move and did not; until somebody says hold
  bool limits_narrower_ = false;
  topic::ArmState state_{};
};

}  // namespace motionlab::comau

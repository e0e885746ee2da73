/// @file  Every topic of the house: its name, its quality of service, its pace, its partition. Nowhere else.
#pragma once

#include <array>
#include <string_view>
#include <type_traits>

#include "drivers/core/time.hpp"
#include "idl/topics.hpp"

namespace motionlab::bus {

/// How a topic travels on DDS.
enum class QosClass {
  sensor,   ///< best effort, volatile, keep last 1, deadline of three periods
  command,  ///< reliable, volatile, keep last 1, liveliness manual by topic on both sides, lifespan
  state,    ///< reliable, transient local, keep last 1: a late joiner gets the present state
  event,    ///< reliable, transient local, keep last 100: a late joiner gets the recent past
  request,  ///< reliable, volatile, keep last 16 per instance, shared ownership
};

/// A writer of commands that is silent for this long is reported as gone.
inline constexpr Nanoseconds kCommandLiveliness = 200ms;
/// A command older than this is not delivered. Hosts that exchange commands need synchronised clocks.
inline constexpr Nanoseconds kCommandLifespan = 100ms;
/// A deadline is this many periods.
inline constexpr int kDeadlinePeriods = 3;
/// Instances of one topic (devices, bodies) that a writer of ours may have.
inline constexpr int kMaxWrittenInstances = 64;
/// Instances that a reader keeps apart, whoever writes them. Far more than anybody means to write: to make
/// room for one more, Fast DDS 2.9 forgets one whose writer has gone, samples that wait to be taken and all,
/// and ends the process when it comes to them.
inline constexpr int kMaxReadInstances = 4096;
/// The partition of the simulated truth. The gateway never joins it.
inline constexpr std::string_view kTruthPartition = "truth";

/// What a topic has unless its traits say otherwise.
struct TopicDefaults {
  /// Seconds from sample to sample; the unit of the deadline. 0: no rhythm.
  static constexpr double period_s = 0;
  /// Made faster than people and disks want it: DDS gets the newest once per period, local readers get all.
  static constexpr bool paced = false;
  static constexpr std::string_view partition = "";
  /// Fields that are NaN on purpose (not wired, no such thing). Any other NaN or infinity is refused on
  /// arrival.
  static constexpr std::array<std::string_view, 0> may_be_nan{};
};

template <class T>
struct TopicTraits;

template <>
struct TopicTraits<topic::Mru> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/mru";
  static constexpr QosClass qos = QosClass::sensor;
  static constexpr double period_s = 0.005;
  /// What the PLC's remote reply lacks of a unit.
  static constexpr std::array<std::string_view, 5> may_be_nan{
      "omega_down_radps", "v_mru_mps", "a_mru_mps2", "a_heading_origin_mps2", "sensor_temperature_degc"};
};

template <>
struct TopicTraits<topic::Bodies> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/bodies";
  static constexpr QosClass qos = QosClass::sensor;
  static constexpr double period_s = 0.005;
  static constexpr std::array<std::string_view, 1> may_be_nan{"residual_m"};
};

template <>
struct TopicTraits<topic::ArmState> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/arm_state";
  static constexpr QosClass qos = QosClass::sensor;
  static constexpr double period_s = 0.005;
};

template <>
struct TopicTraits<topic::ArmCommand> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/arm_command";
  static constexpr QosClass qos = QosClass::command;
  static constexpr double period_s = 0.005;
};

template <>
struct TopicTraits<topic::WinchState> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/winch_state";
  static constexpr QosClass qos = QosClass::sensor;
  static constexpr double period_s = 0.005;
  static constexpr std::array<std::string_view, 2> may_be_nan{"motor_torque_nm", "motor_temperature_degc"};
};

template <>
struct TopicTraits<topic::WinchCommand> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/winch_command";
  static constexpr QosClass qos = QosClass::command;
  static constexpr double period_s = 0.005;
};

template <>
struct TopicTraits<topic::Estimate> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/estimate";
  static constexpr QosClass qos = QosClass::sensor;
  static constexpr double period_s = 0.005;
  static constexpr bool paced = true;
};

template <>
struct TopicTraits<topic::Control> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/control";
  static constexpr QosClass qos = QosClass::sensor;
  static constexpr double period_s = 0.005;
  static constexpr bool paced = true;
};

template <>
struct TopicTraits<topic::Reference> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/reference";
  static constexpr QosClass qos = QosClass::state;
};

template <>
struct TopicTraits<topic::Mode> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/mode";
  static constexpr QosClass qos = QosClass::state;
};

template <>
struct TopicTraits<topic::ModeRequest> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/mode_request";
  static constexpr QosClass qos = QosClass::request;
};

template <>
struct TopicTraits<topic::Health> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/health";
  static constexpr QosClass qos = QosClass::state;
  static constexpr double period_s = 0.1;
};

template <>
struct TopicTraits<topic::Timing> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/timing";
  static constexpr QosClass qos = QosClass::state;
  static constexpr double period_s = 1.0;
};

template <>
struct TopicTraits<topic::Score> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/score";
  static constexpr QosClass qos = QosClass::state;
  static constexpr double period_s = 1.0;
  static constexpr std::array<std::string_view, 4> may_be_nan{
      "baseline_swing_now_deg", "baseline_swing_rms_deg", "baseline_load_error_now_m",
      "baseline_load_error_rms_norm_m"};
};

template <>
struct TopicTraits<topic::Event> : TopicDefaults {
  static constexpr std::string_view name = "motionlab/event";
  static constexpr QosClass qos = QosClass::event;
};

template <>
struct TopicTraits<topic::TruthWorld> : TopicDefaults {
  static constexpr std::string_view name = "truth/world";
  static constexpr QosClass qos = QosClass::sensor;
  static constexpr double period_s = 0.005;
  static constexpr bool paced = true;
  static constexpr std::string_view partition = kTruthPartition;
};

template <>
struct TopicTraits<topic::SimControl> : TopicDefaults {
  static constexpr std::string_view name = "sim/control";
  static constexpr QosClass qos = QosClass::request;
  static constexpr std::string_view partition = kTruthPartition;
};

/// Topics of which each sample counts, from whatever thread it comes: they travel in queues, never as "the
/// newest".
template <class T>
inline constexpr bool kEverySampleCounts =
    TopicTraits<T>::qos == QosClass::event || TopicTraits<T>::qos == QosClass::request ||
    std::is_same_v<T, topic::Reference>;

/// Whether the sample must reach its reader even when nobody had room for others. Several in succession say
/// no more than one.
template <class T>
[[nodiscard]] constexpr bool must_arrive(const T& sample) noexcept {
  if constexpr (std::is_same_v<T, topic::ModeRequest>) {
    return sample.action == topic::ModeAction::settle;
  } else {
    return false;
  }
}

}  // namespace motionlab::bus

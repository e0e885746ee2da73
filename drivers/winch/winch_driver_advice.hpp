/// @file  What the driver tells people, each sentence with the level at which the trouble sits.
#pragma once

#include <string_view>

namespace motionlab::winch::advice {

inline constexpr std::string_view kRefused =
    "AMS/TCP: winch controller refuses the TCP connection: check its address, that TwinCAT runs, and that "
    "plain ADS (48898) is allowed";
inline constexpr std::string_view kNoAnswer =
    "AMS/TCP: winch controller does not answer: check power, cable and address";
inline constexpr std::string_view kBroken =
    "AMS/TCP: connection to the winch controller broke; connecting again";
inline constexpr std::string_view kMalformed =
    "AMS/TCP: winch controller sent a malformed frame: is the address that of an ADS port?";
inline constexpr std::string_view kPortNotFound =
    "AMS router: winch PLC runtime is not there (AMS error 6): log in with TwinCAT and set the PLC to run";
inline constexpr std::string_view kNotRun = "ADS device: winch PLC is not in run: start it from TwinCAT";
inline constexpr std::string_view kSystemNotRun =
    "ADS device: TwinCAT system on the winch controller is not in run: set it to run mode";
inline constexpr std::string_view kWrongProject =
    "ADS device: winch PLC project lacks GVL_Winch: download the project that has stCommand and stStatus";
inline constexpr std::string_view kLacksLegacy =
    "ADS device: winch PLC project lacks MAIN.winch: choose the profile gvl_winch, or load the project that "
    "has it";
inline constexpr std::string_view kLayout =
    "PLC: winch PLC structs are not ours (size, type or layout version): align gateway and PLC project, then "
    "restart";
inline constexpr std::string_view kStandsStill = "PLC: winch status stands still: is the PLC task running?";
inline constexpr std::string_view kWatchdog =
    "PLC: winch watchdog tripped (heartbeat lost): settle, reset, then enable again";
inline constexpr std::string_view kCommandPath =
    "PLC: winch does not echo our heartbeat: does another client command it?";
inline constexpr std::string_view kReadOnly =
    "PLC: winch is only listened to: its project has no watchdog; load the one with GVL_Winch to command it";

}  // namespace motionlab::winch::advice

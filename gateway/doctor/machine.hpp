/// @file  What this machine grants to a program that must be in time: scheduling, processors, clock, disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/doctor/finding.hpp"
#include "gateway/service/gateway_config.hpp"

namespace motionlab::doctor {

/// As the kernel tells it. Nothing where it does not.
struct Machine {
  std::string kernel;  ///< release
  bool preempt_rt = false;
  int processors = 1;
  std::vector<int> isolated;           ///< processors that the scheduler leaves alone
  std::vector<std::string> governors;  ///< of frequency, one per processor that has one
  bool is_virtual = false;             ///< a guest, whose idle processors are given to others
  int wakes_after_us = 0;              ///< from a processor's deepest sleep, as the kernel knows it
  bool grants_fifo = false;            ///< SCHED_FIFO at the priority of the deadman, to whoever asks here
  bool grants_lock = false;            ///< all of a process' memory may be locked
  std::string clock_source;
  bool clock_disciplined = false;       ///< by NTP or PTP
  std::optional<double> clock_error_s;  ///< its estimated maximum, while it is disciplined
  std::uint64_t shared_files = 0;       ///< of DDS programs, in shared memory
  std::uint64_t shared_bytes = 0;
  std::string recordings;  ///< the folder that recordings go to; empty: none is made
  std::optional<std::uint64_t> recordings_free_bytes;
};

[[nodiscard]] Machine look_at_machine(const service::GatewayConfig& config);

[[nodiscard]] Findings judge(const Machine& machine, const service::GatewayConfig& config);

/// "0-2,5" as numbers; what is no such list is empty.
[[nodiscard]] std::vector<int> processor_list(std::string_view text);

}  // namespace motionlab::doctor

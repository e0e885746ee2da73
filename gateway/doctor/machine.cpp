#include "gateway/doctor/machine.hpp"

#include <sched.h>
#include <sys/resource.h>
#include <sys/timex.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>

#include "gateway/monitor/text.hpp"

namespace motionlab::doctor {
namespace {

namespace fs = std::filesystem;

constexpr int kHighestPriority = 90;  // the deadman's
constexpr std::uint64_t kGiga = 1'000'000'000;
constexpr std::uint64_t kRoomToRecord = 10 * kGiga;
constexpr double kClockErrorToCompareHosts_s = 0.001;
constexpr int kPromptAwakening_us = 20;

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

std::vector<std::string> governors() {
  std::vector<std::string> all;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator("/sys/devices/system/cpu", none)) {
    const auto governor = first_line(entry.path() / "cpufreq/scaling_governor");
    if (!governor.empty()) all.push_back(governor);
  }
  return all;
}

/// [us], of the deepest sleep that the kernel chooses.
int longest_awakening() {
  int longest = 0;
  std::error_code none;
  for (const auto& state : fs::directory_iterator("/sys/devices/system/cpu/cpu0/cpuidle", none)) {
    const std::string latency = first_line(state.path() / "latency");
    int us = 0;
    std::from_chars(latency.data(), latency.data() + latency.size(), us);
    longest = std::max(longest, us);
  }
  return longest;
}

bool is_guest() {
  std::ifstream processors("/proc/cpuinfo");
  for (std::string line; std::getline(processors, line);) {
    if (line.starts_with("flags") && line.find(" hypervisor") != std::string::npos) return true;
  }
  return false;
}

/// A capability in the effective set of this process.
bool capable(int bit) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("CapEff:")) return (std::stoull(line.substr(7), nullptr, 16) >> bit & 1U) != 0;
  }
  return false;
}
constexpr int kCapIpcLock = 14;
constexpr int kCapSysNice = 23;

rlim_t limit(decltype(RLIMIT_RTPRIO) which) {
  rlimit now{};
  return getrlimit(which, &now) == 0 ? now.rlim_cur : 0;
}

void look_at_clock(Machine& machine) {
  machine.clock_source = first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  timex clock{};
  const int state = adjtimex(&clock);
  machine.clock_disciplined = state >= 0 && state != TIME_ERROR && (clock.status & STA_UNSYNC) == 0;
  if (machine.clock_disciplined) machine.clock_error_s = 1e-6 * static_cast<double>(clock.maxerror);
}

void look_at_shared_memory(Machine& machine) {
  std::error_code none;
  for (const auto& entry : fs::directory_iterator("/dev/shm", none)) {
    const auto name = entry.path().filename().string();
    if (!name.starts_with("fastrtps_") && !name.starts_with("fast_datasharing")) continue;
    ++machine.shared_files;
    machine.shared_bytes += entry.file_size(none);
  }
}

void look_at_disk(Machine& machine, const std::string& inputs) {
  if (inputs.empty()) return;
  machine.recordings = fs::absolute(inputs).parent_path().string();
  std::error_code gone;
  const auto space = fs::space(machine.recordings, gone);
  if (!gone) machine.recordings_free_bytes = space.available;
}

std::string listed(const std::vector<int>& numbers) {
  std::string text;
  for (const int number : numbers) text += (text.empty() ? "" : ", ") + std::to_string(number);
  return text.empty() ? "none" : text;
}

void judge_scheduling(const Machine& machine, Findings& say) {
  if (machine.preempt_rt) {
    say.push_back({Grade::pass, "kernel", machine.kernel + ", real-time", ""});
  } else {
    say.push_back(
        {Grade::warn, "kernel",
         machine.kernel + " is no real-time kernel: now and then a thread wakes some milliseconds late",
         "apt install linux-image-rt-amd64; measure with cyclictest -m -p 80"});
  }
  if (machine.grants_fifo) {
    say.push_back({Grade::pass, "scheduling", "SCHED_FIFO is granted", ""});
  } else {
    say.push_back(
        {Grade::warn, "scheduling",
         "this user is not granted SCHED_FIFO: other programs delay a gateway that is started by hand",
         "start it by systemctl, whose unit asks for LimitRTPRIO=90"});
  }
  if (machine.grants_lock) {
    say.push_back({Grade::pass, "memory", "memory can be locked", ""});
  } else {
    say.push_back({Grade::warn, "memory", "this user cannot lock memory: page faults delay control",
                   "start it by systemctl, whose unit asks for LimitMEMLOCK=infinity"});
  }
}

void judge_sleep(const Machine& machine, const service::GatewayConfig& config, Findings& say) {
  if (config.control_awake) {
    say.push_back(
        {Grade::pass, "sleep", "processor " + std::to_string(config.control_cpu) + " is kept awake", ""});
  } else if (machine.is_virtual || machine.wakes_after_us > kPromptAwakening_us) {
    say.push_back({Grade::warn, "sleep",
                   machine.is_virtual
                       ? "a virtual machine: a processor that idles is given to others, and comes back late"
                       : "a processor needs " + std::to_string(machine.wakes_after_us) +
                             " us to wake from its deepest sleep",
                   "give control a processor of its own and keep it awake: [control] cpu and awake = true"});
  } else {
    say.push_back({Grade::pass, "sleep",
                   "a processor wakes within " + std::to_string(machine.wakes_after_us) + " us", ""});
  }
}

void judge_processors(const Machine& machine, const service::GatewayConfig& config, Findings& say) {
  const auto slow = std::ranges::find_if(machine.governors, [](const auto& g) { return g != "performance"; });
  if (machine.governors.empty()) {
    say.push_back({Grade::pass, "governor", "the kernel does not change the processors' frequency", ""});
  } else if (slow == machine.governors.end()) {
    say.push_back({Grade::pass, "governor", "performance", ""});
  } else {
    say.push_back({Grade::warn, "governor", *slow + ": a sleeping processor needs time to get up",
                   "cpupower frequency-set -g performance"});
  }
  for (const auto& [key, cpu] : {std::pair{"cpu", config.control_cpu}, {"io_cpu", config.io_cpu}}) {
    const std::string subject = std::string("[control] ") + key;
    if (cpu < 0) continue;
    if (cpu >= machine.processors) {
      say.push_back({Grade::fail, subject,
                     "processor " + std::to_string(cpu) + " is not here; there are " +
                         std::to_string(machine.processors) + ", from 0",
                     "choose one of them, or -1"});
    } else if (std::ranges::find(machine.isolated, cpu) == machine.isolated.end()) {
      say.push_back({Grade::warn, subject,
                     "processor " + std::to_string(cpu) +
                         " is shared with other programs; isolated: " + listed(machine.isolated),
                     "boot with isolcpus=" + std::to_string(cpu) + ", or give -1"});
    } else {
      say.push_back({Grade::pass, subject, "processor " + std::to_string(cpu) + " is isolated", ""});
    }
  }
}

void judge_clock(const Machine& machine, Findings& say) {
  if (!machine.clock_disciplined) {
    say.push_back({Grade::warn, "clock",
                   "nobody disciplines this machine's clock (" + machine.clock_source +
                       "): times of other hosts cannot be compared with its own",
                   "apt install chrony, or linuxptp where the network has a PTP master"});
  } else if (machine.clock_error_s.value_or(0) > kClockErrorToCompareHosts_s) {
    say.push_back({Grade::warn, "clock",
                   "disciplined, but only within " + monitor::fixed(1e3 * *machine.clock_error_s, 1) +
                       " ms: enough for one host, too little to exchange commands with others",
                   "use a nearer time server, or PTP"});
  } else {
    say.push_back({Grade::pass, "clock", "disciplined (" + machine.clock_source + ")", ""});
  }
}

void judge_storage(const Machine& machine, Findings& say) {
  if (machine.shared_files > 0) {
    say.push_back({Grade::warn, "shared memory",
                   std::to_string(machine.shared_files) + " files of DDS programs, " +
                       std::to_string(machine.shared_bytes / 1'000'000) +
                       " MB; the gateway uses none: they are of others, or left behind",
                   "fastdds shm clean, when no such program runs"});
  } else {
    say.push_back({Grade::pass, "shared memory", "nothing is left behind", ""});
  }
  if (machine.recordings.empty()) return;
  if (!machine.recordings_free_bytes) {
    say.push_back({Grade::fail, "disk", "[record] inputs: there is no folder " + machine.recordings,
                   "mkdir -p " + machine.recordings + ", for the user that the gateway runs as"});
  } else if (*machine.recordings_free_bytes < kRoomToRecord) {
    say.push_back({Grade::warn, "disk",
                   monitor::fixed(static_cast<double>(*machine.recordings_free_bytes) / kGiga, 1) +
                       " GB are free for recordings in " + machine.recordings,
                   "move old ones away"});
  } else {
    say.push_back(
        {Grade::pass, "disk",
         std::to_string(*machine.recordings_free_bytes / kGiga) + " GB are free in " + machine.recordings,
         ""});
  }
}

}  // namespace

std::vector<int> processor_list(std::string_view text) {
  std::vector<int> all;
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto number = [&](int& value) {
    const auto [next, bad] = std::from_chars(at, end, value);
    at = next;
    return bad == std::errc{};
  };
  while (at < end) {
    int first = 0;
    if (!number(first)) return {};
    int last = first;
    if (at < end && *at == '-') {
      ++at;
      if (!number(last)) return {};
    }
    for (int each = first; each <= last; ++each) all.push_back(each);
    if (at < end && *at != ',') return {};
    ++at;
  }
  return all;
}

Machine look_at_machine(const service::GatewayConfig& config) {
  Machine machine;
  utsname name{};
  if (uname(&name) == 0) machine.kernel = name.release;
  machine.preempt_rt = first_line("/sys/kernel/realtime") == "1";
  machine.processors = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  machine.isolated = processor_list(first_line("/sys/devices/system/cpu/isolated"));
  machine.governors = governors();
  machine.is_virtual = is_guest();
  machine.wakes_after_us = longest_awakening();
  machine.grants_fifo = capable(kCapSysNice) || limit(RLIMIT_RTPRIO) >= kHighestPriority;
  machine.grants_lock = capable(kCapIpcLock) || limit(RLIMIT_MEMLOCK) == RLIM_INFINITY;
  look_at_clock(machine);
  look_at_shared_memory(machine);
  look_at_disk(machine, config.record.inputs);
  return machine;
}

Findings judge(const Machine& machine, const service::GatewayConfig& config) {
  Findings say;
  judge_scheduling(machine, say);
  judge_processors(machine, config, say);
  judge_sleep(machine, config, say);
  judge_clock(machine, say);
  judge_storage(machine, say);
  return say;
}

}  // namespace motionlab::doctor

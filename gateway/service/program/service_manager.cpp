#include "gateway/service/program/service_manager.hpp"

#include <systemd/sd-daemon.h>
#include <time.h>

#include <chrono>
#include <cstdint>

namespace motionlab::service {

ServiceManager::ServiceManager() {
  std::uint64_t usec = 0;
  if (sd_watchdog_enabled(0, &usec) > 0) watchdog_ = std::chrono::microseconds{usec};
}

void ServiceManager::waiting(const std::string& status, Nanoseconds patience) const {
  const auto usec = std::chrono::duration_cast<std::chrono::microseconds>(patience).count();
  sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%lld\nSTATUS=%s", static_cast<long long>(usec), status.c_str());
}

void ServiceManager::ready() const {
  sd_notify(0, "READY=1");
}

void ServiceManager::status(const std::string& status) const {
  sd_notifyf(0, "STATUS=%s", status.c_str());
}

void ServiceManager::stroke() const {
  sd_notify(0, "WATCHDOG=1");
}

void ServiceManager::reloading() const {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const long long usec = static_cast<long long>(now.tv_sec) * 1'000'000 + now.tv_nsec / 1000;
  sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%lld", usec);
}

void ServiceManager::stopping() const {
  sd_notify(0, "STOPPING=1");
}

}  // namespace motionlab::service

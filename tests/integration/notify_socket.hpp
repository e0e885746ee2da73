/// @file  The service manager's end of sd_notify, for a test that stands in for systemd.
#pragma once

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace motionlab::integration {

/// Programs started while it lives tell it what they would tell systemd, and believe that they are watched.
class NotifySocket {
 public:
  explicit NotifySocket(std::chrono::microseconds watchdog)
      : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    const std::string name = "motionlab-test-" + std::to_string(::getpid());
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path + 1, name.data(), name.size());  // abstract: begins with a zero
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
      throw std::runtime_error("cannot bind the socket of the service manager");
    }
    ::setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
    ::setenv("WATCHDOG_USEC", std::to_string(watchdog.count()).c_str(), 1);
  }
  ~NotifySocket() {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
    ::close(fd_);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  /// Takes what has come. Once in a while, or the socket fills up and the program waits.
  void listen() {
    std::array<char, 4096> text{};
    for (ssize_t size = 0; (size = ::recv(fd_, text.data(), text.size(), 0)) >= 0;) {
      heard_.emplace_back(text.data(), static_cast<std::size_t>(size));
    }
  }
  /// Whether a message with this in it has come since `forget`.
  [[nodiscard]] bool heard(const std::string& words) {
    listen();
    for (const auto& message : heard_) {
      if (message.find(words) != std::string::npos) return true;
    }
    return false;
  }
  void forget() {
    listen();
    heard_.clear();
  }
  [[nodiscard]] std::string all() const {
    std::string text;
    for (const auto& message : heard_) text += message + '\n';
    return text;
  }

 private:
  int fd_;
  std::vector<std::string> heard_;
};

}  // namespace motionlab::integration

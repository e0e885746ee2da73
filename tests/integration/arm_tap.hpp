/// @file  Somebody in the middle of the arm's wire, who writes down what was commanded, and when it arrived.
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <time.h>

#include <array>
#include <atomic>
#include <cstring>
#include <mutex>
#include <thread>
#include <vector>

#include "drivers/comau/comau_wire.hpp"
#include "tests/integration/processes.hpp"

namespace motionlab::integration {

/// CLOCK_REALTIME, as the kernel stamps datagrams by.
inline std::int64_t real_time_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

/// A command as it came to the arm's end of the wire.
struct Seen {
  std::int64_t t_ns = 0;  ///< when the kernel took it, in real time
  comau::Command command{};

  [[nodiscard]] bool follows() const {
    return command.mode == static_cast<std::int32_t>(comau::Mode::follow);
  }
  [[nodiscard]] double fastest_radps() const {
    double fastest = 0;
    for (const float qd : command.qd_radps) fastest = std::max(fastest, std::abs(static_cast<double>(qd)));
    return fastest;
  }
};

/// Passes datagrams on between whoever commands (it is their robot computer) and the simulated robot
/// computer.
class ArmTap {
 public:
  ArmTap(std::uint16_t port, std::uint16_t robot_port)
      : front_(SOCK_DGRAM, port), back_(SOCK_DGRAM), robot_port_(robot_port), thread_([this] { run(); }) {
    const int on = 1;
    ::setsockopt(front_.fd(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  }
  ~ArmTap() {
    over_ = true;
    thread_.join();
  }
  ArmTap(const ArmTap&) = delete;
  ArmTap& operator=(const ArmTap&) = delete;

  /// All that was commanded since the last `clear`.
  [[nodiscard]] std::vector<Seen> seen() const {
    const std::lock_guard lock(mutex_);
    return seen_;
  }
  void clear() {
    const std::lock_guard lock(mutex_);
    seen_.clear();
  }

 private:
  void run() {
    std::array<pollfd, 2> sockets{{{front_.fd(), POLLIN, 0}, {back_.fd(), POLLIN, 0}}};
    while (!over_) {
      (void)::poll(sockets.data(), sockets.size(), 20);
      take_commands();
      pass_answers();
    }
  }

  void take_commands() {
    std::array<std::uint8_t, 2048> bytes{};
    for (;;) {
      sockaddr_in from{};
      alignas(cmsghdr) std::array<char, 128> control{};
      iovec part{bytes.data(), bytes.size()};
      msghdr message{};
      message.msg_name = &from;
      message.msg_namelen = sizeof from;
      message.msg_iov = &part;
      message.msg_iovlen = 1;
      message.msg_control = control.data();
      message.msg_controllen = control.size();
      const ssize_t length = ::recvmsg(front_.fd(), &message, 0);
      if (length < 0) return;
      client_port_ = ntohs(from.sin_port);
      const Bytes datagram(bytes.data(), static_cast<std::size_t>(length));
      back_.send_to(robot_port_, {datagram.begin(), datagram.end()});
      const auto command = comau::decode_command(datagram);
      if (!command) continue;
      const std::lock_guard lock(mutex_);
      seen_.push_back({stamp_of(message), *command});
    }
  }

  static std::int64_t stamp_of(msghdr& message) {
    for (cmsghdr* header = CMSG_FIRSTHDR(&message); header; header = CMSG_NXTHDR(&message, header)) {
      if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_TIMESTAMPNS) continue;
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(header), sizeof stamp);
      return stamp.tv_sec * 1'000'000'000LL + stamp.tv_nsec;
    }
    return real_time_ns();
  }

  void pass_answers() {
    std::array<std::uint8_t, 2048> bytes{};
    for (;;) {
      const ssize_t length = ::recv(back_.fd(), bytes.data(), bytes.size(), 0);
      if (length < 0) return;
      front_.send_to(client_port_, {bytes.begin(), bytes.begin() + length});
    }
  }

  RawSocket front_;
  RawSocket back_;
  std::uint16_t robot_port_;
  std::uint16_t client_port_ = 0;
  mutable std::mutex mutex_;
  std::vector<Seen> seen_;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

}  // namespace motionlab::integration

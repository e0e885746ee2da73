/// @file  Sends datagrams to UDP ports as fast as it is told to and the machine allows.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace motionlab::test {

using Datagrams = std::vector<std::vector<std::uint8_t>>;

/// Shoots from its birth to its end, from several threads, in batches of 64 a system call.
class DatagramGun {
 public:
  DatagramGun(const std::string& address, const std::vector<std::uint16_t>& ports, Datagrams datagrams,
              double per_second, int threads)
      : datagrams_(std::move(datagrams)) {
    for (const auto port : ports) {
      sockaddr_in target{};
      target.sin_family = AF_INET;
      target.sin_port = htons(port);
      if (::inet_pton(AF_INET, address.c_str(), &target.sin_addr) != 1) {
        throw std::invalid_argument(address + " is no IPv4 address");
      }
      targets_.push_back(target);
    }
    for (int i = 0; i < threads; ++i) threads_.emplace_back([=, this] { shoot(per_second / threads); });
  }
  ~DatagramGun() {
    over_ = true;
    for (auto& thread : threads_) thread.join();
  }
  DatagramGun(const DatagramGun&) = delete;
  DatagramGun& operator=(const DatagramGun&) = delete;

  /// What the kernel took. It may still drop it before the reader's queue.
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  static constexpr std::size_t kBatch = 64;

  void shoot(double per_second) {
    using std::chrono::steady_clock;
    const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
    std::array<iovec, kBatch> parts{};
    std::array<mmsghdr, kBatch> messages{};
    std::size_t next = 0;
    double due = 0;
    auto last = steady_clock::now();
    while (!over_) {
      const auto now = steady_clock::now();
      // What could not be sent in time is not made up for.
      due += std::min(std::chrono::duration<double>(now - last).count(), 0.02) * per_second;
      last = now;
      for (; due >= static_cast<double>(kBatch) && !over_; due -= static_cast<double>(kBatch)) {
        for (std::size_t i = 0; i < kBatch; ++i, ++next) {
          auto& bytes = datagrams_[next % datagrams_.size()];
          parts[i] = {bytes.data(), bytes.size()};
          messages[i].msg_hdr = {};
          messages[i].msg_hdr.msg_name = &targets_[next % targets_.size()];
          messages[i].msg_hdr.msg_namelen = sizeof(sockaddr_in);
          messages[i].msg_hdr.msg_iov = &parts[i];
          messages[i].msg_hdr.msg_iovlen = 1;
        }
        const int taken = ::sendmmsg(fd, messages.data(), kBatch, 0);
        if (taken > 0) sent_ += static_cast<std::uint64_t>(taken);
      }
      std::this_thread::sleep_for(std::chrono::microseconds{300});
    }
    ::close(fd);
  }

  Datagrams datagrams_;
  std::vector<sockaddr_in> targets_;
  std::atomic<std::uint64_t> sent_{0};
  std::atomic<bool> over_{false};
  std::vector<std::thread> threads_;
};

}  // namespace motionlab::test

/// @file  Programs as children: started, watched, ended. For tests on real sockets.
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

extern char** environ;

namespace motionlab::integration {

/// Looks again and again until `done()` holds. @returns false when it did not within the patience
template <class Done>
bool eventually(Done&& done, std::chrono::seconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!done()) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds{10});
  }
  return true;
}

/// A running program with its output in a file. Killed, and waited for, at the end of its life.
class Child {
 public:
  Child(const std::vector<std::string>& command, std::filesystem::path log) : log_(std::move(log)) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                     0600);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    std::vector<char*> arguments;
    std::vector<std::string> texts = command;
    for (auto& text : texts) arguments.push_back(text.data());
    arguments.push_back(nullptr);
    const int failed = posix_spawn(&pid_, arguments.front(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) throw std::runtime_error("cannot start " + command.front());
  }
  ~Child() {
    if (!running()) return;
    ::kill(pid_, SIGKILL);
    (void)exit_code(std::chrono::seconds{10});
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void send(int signal) const { ::kill(pid_, signal); }
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] bool running() { return !exit_code(std::chrono::seconds{0}).has_value(); }
  /// How it ended: its exit code, or minus the signal. Nothing when it still runs after the patience.
  std::optional<int> exit_code(std::chrono::seconds patience) {
    (void)eventually(
        [this] {
          int status = 0;
          if (!ended_ && waitpid(pid_, &status, WNOHANG) == pid_) {
            ended_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
          }
          return ended_.has_value();
        },
        patience);
    return ended_;
  }
  [[nodiscard]] std::string output() const {
    std::ifstream file(log_);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }

 private:
  std::filesystem::path log_;
  pid_t pid_ = -1;
  std::optional<int> ended_;
};

/// Processor time of a process so far, in seconds.
[[nodiscard]] inline double processor_s(pid_t process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(in, text);
  std::istringstream fields(text.substr(text.rfind(')') + 2));
  std::string word;
  for (int i = 3; i < 14; ++i) fields >> word;  // up to field 13, cmajflt
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

/// A socket of the test's own on 127.0.0.1.
class RawSocket {
 public:
  explicit RawSocket(int type, std::uint16_t port = 0) : fd_(::socket(AF_INET, type | SOCK_NONBLOCK, 0)) {
    const sockaddr_in local = address(port);
    if (::bind(fd_, reinterpret_cast<const sockaddr*>(&local), sizeof local) != 0) {
      throw std::runtime_error("cannot bind a port of the test");
    }
  }
  ~RawSocket() { ::close(fd_); }
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] std::uint16_t port() const {
    sockaddr_in local{};
    socklen_t size = sizeof local;
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&local), &size);
    return ntohs(local.sin_port);
  }
  void send_to(std::uint16_t port, const std::vector<std::uint8_t>& bytes) const {
    const sockaddr_in to = address(port);
    (void)::sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  /// Whether a datagram waits.
  [[nodiscard]] bool heard() const {
    std::uint8_t byte = 0;
    return ::recv(fd_, &byte, 1, 0) >= 0;
  }

 private:
  static sockaddr_in address(std::uint16_t port) {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    result.sin_port = htons(port);
    return result;
  }
  int fd_;
};

}  // namespace motionlab::integration

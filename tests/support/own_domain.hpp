/// @file  A DDS domain of one's own.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>

namespace motionlab::test {

/// A domain that no other program of ours uses on this machine at the same time; the same for as long as this
/// one runs.
///
/// Its number is claimed by the name of a socket, which the kernel gives free when the program ends. All are
/// below 85, the domains of the scripts in tests/interop, and so are their ports below those that the kernel
/// gives to others.
inline int own_domain() {
  static const int domain = [] {
    constexpr int kFirst = 43, kEnd = 85;
    for (int i = 0; i < kEnd - kFirst; ++i) {
      const int wanted = kFirst + (static_cast<int>(getpid()) + i) % (kEnd - kFirst);
      const std::string name = "motionlab-domain-" + std::to_string(wanted);
      sockaddr_un address{};
      address.sun_family = AF_UNIX;
      std::memcpy(address.sun_path + 1, name.data(), name.size());  // behind a zero: a name that is no file
      const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
      const int held = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
      if (::bind(held, reinterpret_cast<const sockaddr*>(&address), size) == 0) return wanted;
      ::close(held);
    }
    throw std::runtime_error("every DDS domain from 43 to 84 is in use by a test");
  }();
  return domain;
}

}  // namespace motionlab::test

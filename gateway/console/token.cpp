#include "gateway/console/token.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "drivers/core/error.hpp"

namespace motionlab::console {
namespace {

constexpr std::size_t kShortest = 16, kLongest = 256;

}  // namespace

std::string make_token() {
  std::array<std::uint8_t, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw StartupError{
        "the kernel gives no random bytes for a token: write one into a file and name it with --token-file"};
  }
  constexpr std::string_view digits = "0123456789abcdef";
  std::string token;
  for (const std::uint8_t byte : bytes) {
    token += digits[byte >> 4];
    token += digits[byte & 15];
  }
  return token;
}

std::string read_token(const std::filesystem::path& file) {
  const std::string name = file.string();
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw StartupError{"the token file " + name + " cannot be read: " + std::strerror(errno)};
  struct stat status {};
  std::array<char, kLongest + 2> text{};
  const bool told = ::fstat(fd, &status) == 0;
  const ssize_t size = told ? ::read(fd, text.data(), text.size()) : -1;
  ::close(fd);
  if (!told || size < 0 || !S_ISREG(status.st_mode))
    throw StartupError{"the token file " + name + " is no file"};
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    throw StartupError{"the token file " + name + " can be read by others than its owner: chmod 600 " + name};
  }
  std::string token{text.data(), static_cast<std::size_t>(size)};
  token.resize(std::min(token.find_first_of("\r\n"), token.size()));
  if (token.size() < kShortest || token.size() > kLongest) {
    throw StartupError{"the token in " + name + " has " + std::to_string(token.size()) +
                       " characters; it needs 16 to 256. Make one: (umask 077; openssl rand -hex 16 > " +
                       name + ")"};
  }
  return token;
}

bool same_token(std::string_view given, std::string_view wanted) noexcept {
  unsigned difference = given.size() == wanted.size() && !wanted.empty() ? 0U : 1U;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const char other = wanted.empty() ? '\0' : wanted[i % wanted.size()];
    difference |= static_cast<unsigned char>(given[i] ^ other);
  }
  return difference == 0;
}

}  // namespace motionlab::console

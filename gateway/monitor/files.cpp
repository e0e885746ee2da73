#include "gateway/monitor/files.hpp"

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "drivers/core/error.hpp"

namespace motionlab::monitor {

std::ifstream open_recording(const std::filesystem::path& file) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw StartupError{"cannot read " + file.string() + ": " + std::strerror(errno)};
  if (std::filesystem::is_directory(file))
    throw StartupError{file.string() + " is a folder: name a file in it"};
  return in;
}

std::ofstream make_file(const std::filesystem::path& file) {
  if (std::filesystem::exists(file)) {
    throw StartupError{file.string() + " exists already and is not written over: choose another name"};
  }
  errno = 0;
  std::ofstream out(file, std::ios::binary);
  if (!out) throw StartupError{"cannot make " + file.string() + ": " + std::strerror(errno)};
  return out;
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) throw StartupError{"cannot make the folder " + folder.string() + ": " + failed.message()};
}

}  // namespace motionlab::monitor

#include "drivers/core/config_path.hpp"

#include <cstdlib>
#include <string>
#include <vector>

#include "drivers/core/error.hpp"

namespace motionlab {

std::filesystem::path find_config(std::string_view name) {
  std::vector<std::filesystem::path> folders;
  if (const char* const wanted = std::getenv("MOTIONLAB_CONFIG_DIR")) folders.emplace_back(wanted);
  folders.emplace_back("deploy/config");
  folders.emplace_back("/etc/motionlab");
  std::string tried;
  for (const auto& folder : folders) {
    const auto file = folder / name;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored)) return file;
    tried += (tried.empty() ? "" : ", ") + file.string();
  }
  throw StartupError("no " + std::string(name) + " found (looked for " + tried +
                     "); run from the source tree, set MOTIONLAB_CONFIG_DIR or name the file");
}

}  // namespace motionlab

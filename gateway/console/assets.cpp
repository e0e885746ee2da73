#include "gateway/console/assets.hpp"

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <utility>

#include "drivers/core/error.hpp"

namespace motionlab::console {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kTypes{{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".txt", "text/plain; charset=utf-8"},
}};

std::string type_of(const fs::path& file) {
  for (const auto& [ending, type] : kTypes) {
    if (file.extension() == ending) return std::string{type};
  }
  throw StartupError{file.string() + " is not of a kind that the page has"};
}

/// FNV-1a, 64 bits: tells versions of a file apart, guards nothing.
std::string etag_of(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 1099511628211ULL;
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "\"%016llx\"", static_cast<unsigned long long>(hash));
  return text.data();
}

}  // namespace

Assets::Assets(const fs::path& folder) {
  if (!fs::is_regular_file(folder / "index.html")) {
    throw StartupError{"the page is not in " + folder.string() + ": there is no index.html"};
  }
  for (const auto& entry : fs::recursive_directory_iterator{folder}) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file{entry.path(), std::ios::binary};
    std::stringstream bytes;
    bytes << file.rdbuf();
    if (!file) throw StartupError{entry.path().string() + " cannot be read"};
    std::string path{"/"};
    path += fs::relative(entry.path(), folder).generic_string();
    add(path, type_of(entry.path()), bytes.str());
  }
  assets_["/"] = assets_.at("/index.html");
}

void Assets::add(const std::string& path, std::string type, std::string bytes) {
  std::string etag = etag_of(bytes);
  assets_[path] = {std::move(type), std::move(etag), std::move(bytes)};
}

const Asset* Assets::find(std::string_view path) const {
  const auto found = assets_.find(path);
  return found == assets_.end() ? nullptr : &found->second;
}

fs::path find_page() {
  const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path built = here / "../page", installed = here / "../share/motionlab/console";
  for (const fs::path& folder : {built, installed}) {
    if (fs::is_regular_file(folder / "index.html")) return folder.lexically_normal();
  }
  throw StartupError{"the files of the page are neither in " + built.lexically_normal().string() +
                     " nor in " + installed.lexically_normal().string() +
                     ": build the target motionlab-console, or install it"};
}

}  // namespace motionlab::console

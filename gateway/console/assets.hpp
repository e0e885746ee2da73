/// @file  The files of the page, read once. Whatever is not among them does not exist: no path of a request
/// ever reaches the file system.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace motionlab::console {

struct Asset {
  std::string type;  ///< as in Content-Type
  std::string etag;  ///< of its bytes, with quotes
  std::string bytes;
};

/// By the path of the request: "/", "/app.js", "/vendor/three.module.js".
class Assets {
 public:
  Assets() = default;
  /// Reads every file below the folder; index.html is also "/".
  /// @throws StartupError  no such folder, no index.html, a file of a kind that the page does not have
  explicit Assets(const std::filesystem::path& folder);

  /// One that is made, not read.
  void add(const std::string& path, std::string type, std::string bytes);

  /// Null when there is none.
  [[nodiscard]] const Asset* find(std::string_view path) const;

 private:
  std::map<std::string, Asset, std::less<>> assets_;
};

/// Where the page is: beside the program as it was built, or as it was installed.
/// @throws StartupError that names both places
[[nodiscard]] std::filesystem::path find_page();

}  // namespace motionlab::console

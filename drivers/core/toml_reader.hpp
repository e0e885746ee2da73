/// @file  Configuration files: every value is checked as it is read, every error says where it is and what to
/// write.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/endpoint.hpp"

namespace motionlab {

/// The numbers that are allowed, both ends included.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_excluded = false;  ///< more than `low`, not just at least

  [[nodiscard]] static constexpr Range at_least(double low) noexcept { return {.low = low}; }
  [[nodiscard]] static constexpr Range positive() noexcept { return {.low = 0.0, .low_excluded = true}; }
};

/// The whole numbers that are allowed, both ends included.
struct IntegerRange {
  std::int64_t low = std::numeric_limits<std::int64_t>::min();
  std::int64_t high = std::numeric_limits<std::int64_t>::max();
};

struct TomlNode;

/// One table of a document. A cheap handle; keeps the document alive.
///
/// To read a key is to know it, whether it is there or not. Every function that does not like what it finds
/// throws StartupError "FILE:LINE:COLUMN: [table] key: what is wrong; what to write instead". The functions
/// with a fallback return it when the key is absent, and are as strict as the others when it is there.
class TomlTable {
 public:
  /// A finite number. Whole numbers are numbers too.
  [[nodiscard]] double number(std::string_view key, Range range = {}) const;
  [[nodiscard]] double number_or(std::string_view key, double fallback, Range range = {}) const;

  [[nodiscard]] std::int64_t integer(std::string_view key, IntegerRange range = {}) const;
  [[nodiscard]] std::int64_t integer_or(std::string_view key, std::int64_t fallback,
                                        IntegerRange range = {}) const;

  [[nodiscard]] bool boolean(std::string_view key) const;
  [[nodiscard]] bool boolean_or(std::string_view key, bool fallback) const;

  [[nodiscard]] std::string text(std::string_view key) const;
  [[nodiscard]] std::string text_or(std::string_view key, std::string_view fallback) const;

  /// One of a few words. @returns its index among them
  [[nodiscard]] std::size_t choice(std::string_view key, std::span<const std::string_view> words) const;
  [[nodiscard]] std::size_t choice(std::string_view key,
                                   std::initializer_list<std::string_view> words) const {
    return choice(key, std::span{words.begin(), words.size()});
  }
  [[nodiscard]] std::size_t choice_or(std::string_view key, std::size_t fallback,
                                      std::span<const std::string_view> words) const;
  [[nodiscard]] std::size_t choice_or(std::string_view key, std::size_t fallback,
                                      std::initializer_list<std::string_view> words) const {
    return choice_or(key, fallback, std::span{words.begin(), words.size()});
  }

  /// "192.168.90.13:50013"
  [[nodiscard]] Endpoint endpoint(std::string_view key) const;
  [[nodiscard]] Endpoint endpoint_or(std::string_view key, Endpoint fallback) const;

  /// A list of texts, of any length.
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;
  [[nodiscard]] std::vector<std::string> texts_or(std::string_view key,
                                                  std::vector<std::string> fallback) const;

  /// A list of numbers, of any length.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, Range range = {}) const;

  /// A list of exactly N numbers.
  template <std::size_t N>
  [[nodiscard]] std::array<double, N> numbers(std::string_view key, Range range = {}) const {
    const std::vector<double> read = list(key, N, range);
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) values[i] = read[i];
    return values;
  }
  template <std::size_t N>
  [[nodiscard]] std::array<double, N> numbers_or(std::string_view key, const std::array<double, N>& fallback,
                                                 Range range = {}) const {
    return has(key) ? numbers<N>(key, range) : fallback;
  }

  /// Whether the key is there.
  [[nodiscard]] bool has(std::string_view key) const;
  /// The table [this.key]; an error when it is not there.
  [[nodiscard]] TomlTable table(std::string_view key) const;
  /// The table [this.key]; an empty one when it is not there, so that every fallback of it holds.
  [[nodiscard]] TomlTable table_or_empty(std::string_view key) const;
  /// Every table directly under this one, in the order of their names: for tables that the user names
  /// himself.
  [[nodiscard]] std::vector<TomlTable> tables() const;

  /// The last part of the table's name: "mru1" of [mru.mru1]. Empty for the document.
  [[nodiscard]] const std::string& name() const;
  /// The whole name: "mru.mru1".
  [[nodiscard]] const std::string& path() const;

  /// Throws a StartupError at this key's position (at the table's if it is absent).
  [[noreturn]] void fail(std::string_view key, std::string_view why_and_what_to_do) const;

 private:
  friend class TomlDocument;
  explicit TomlTable(std::shared_ptr<TomlNode> node) : node_(std::move(node)) {}
  [[nodiscard]] std::vector<double> list(std::string_view key, std::optional<std::size_t> count,
                                         Range range) const;

  std::shared_ptr<TomlNode> node_;
};

/// A piece of a document that stands in no file, e.g. on the command line.
struct TomlText {
  std::string source;  ///< where errors point, in place of a file's name
  std::string text;
};

/// A configuration file with others laid over it.
class TomlDocument {
 public:
  /// Reads `file`; then every overlay, in order, and then every text, replaces single values, however deep,
  /// and may add some.
  /// @throws StartupError for a missing file, a syntax error, a duplicate key
  static TomlDocument load(const std::filesystem::path& file,
                           const std::vector<std::filesystem::path>& overlays = {},
                           const std::vector<TomlText>& texts = {});

  /// Reads one text that stands in no file. @throws StartupError likewise
  static TomlDocument parse(const TomlText& text);

  [[nodiscard]] TomlTable root() const { return TomlTable{root_}; }

  /// Call after everything was read. @throws StartupError for the first key that nobody asked for, with the
  /// closest one that somebody did
  void refuse_unknown_keys() const;

  /// The document with its overlays, as TOML, tables and keys sorted.
  [[nodiscard]] std::string effective() const;

 private:
  explicit TomlDocument(std::shared_ptr<TomlNode> root) : root_(std::move(root)) {}
  std::shared_ptr<TomlNode> root_;
};

}  // namespace motionlab

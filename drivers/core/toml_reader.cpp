#include "drivers/core/toml_reader.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <tuple>
#include <utility>

#include "drivers/core/error.hpp"
#include "drivers/core/toml_hint.hpp"

namespace motionlab {

/// A table, and which of its keys somebody asked for. The document is the root, and everything lives as long
/// as it.
struct TomlNode {
  std::string file;  ///< where to point when the table itself has no position
  std::string path;
  std::string name;
  toml::table own;                     ///< of the root, and of a table that is not there
  const toml::table* table = nullptr;  ///< null: look into `own`
  std::set<std::string, std::less<>> asked;
  std::map<std::string, std::unique_ptr<TomlNode>, std::less<>> children;

  [[nodiscard]] const toml::table& values() const { return table ? *table : own; }

  /// The value of a key, which is known from now on.
  const toml::node* ask(std::string_view key) {
    asked.emplace(key);
    return values().get(key);
  }

  TomlNode& child(std::string_view key, const toml::table* child_table) {
    auto& node = children[std::string(key)];
    if (!node) {
      node = std::make_unique<TomlNode>();
      node->file = file;
      node->path = path.empty() ? std::string(key) : path + '.' + std::string(key);
      node->name = key;
      node->table = child_table;
    }
    return *node;
  }
};

namespace {

std::string to_text(const toml::source_region& source, const std::string& file) {
  const std::string& path = source.path ? *source.path : file;
  const auto line = source.begin ? source.begin.line : 1;
  const auto column = source.begin ? source.begin.column : 1;
  return path + ':' + std::to_string(line) + ':' + std::to_string(column);
}

[[noreturn]] void throw_at(const toml::source_region& source, const TomlNode& node, std::string_view key,
                           std::string_view text) {
  std::string message = to_text(source, node.file) + ": ";
  if (!node.path.empty()) message += '[' + node.path + "] ";
  if (!key.empty()) message += std::string(key) + ": ";
  throw StartupError(message + std::string(text));
}

std::string in_quotes(std::string_view text) {
  return '"' + std::string(text) + '"';
}

std::string to_text(double value) {
  char digits[32];
  const auto [end, error] = std::to_chars(std::begin(digits), std::end(digits), value);
  return {digits, end};
}

std::string_view kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

/// What to write for a number of this range.
std::string wanted(const Range& range) {
  const bool low = std::isfinite(range.low);
  const bool high = std::isfinite(range.high);
  const char* const from = range.low_excluded ? "above " : "from ";
  if (low && high) return std::string("a number ") + from + to_text(range.low) + " to " + to_text(range.high);
  if (low)
    return std::string("a number ") + (range.low_excluded ? "above " : "of at least ") + to_text(range.low);
  if (high) return "a number of at most " + to_text(range.high);
  return "a number";
}

std::string wanted(const IntegerRange& range) {
  constexpr IntegerRange any;
  const bool low = range.low != any.low;
  const bool high = range.high != any.high;
  if (low && high)
    return "a whole number from " + std::to_string(range.low) + " to " + std::to_string(range.high);
  if (low) return "a whole number of at least " + std::to_string(range.low);
  if (high) return "a whole number of at most " + std::to_string(range.high);
  return "a whole number";
}

bool is_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

[[noreturn]] void throw_wrong_type(const toml::node& found, const TomlNode& node, std::string_view key,
                                   const std::string& wanted) {
  std::string text = std::string(kind_of(found)) + " stands where " + wanted + " belongs; write ";
  const auto* written = found.as_string();
  if (written && wanted.find("number") != std::string::npos && is_number(written->get())) {
    text += written->get() + " without quotes";
  } else if (wanted == "a text") {
    text += "it in \"quotes\"";
  } else {
    text += wanted;
  }
  throw_at(found.source(), node, key, text);
}

/// Somebody may have written the key in another unit: then that is what to say.
[[noreturn]] void throw_missing(TomlNode& node, std::string_view key, const std::string& wanted) {
  for (const auto& [written, value] : node.values()) {
    if (node.asked.contains(written.str()) || !differ_in_unit_only(written.str(), key)) continue;
    std::string text = "unknown key " + std::string(written.str()) + "; did you mean " + std::string(key);
    if (const auto unit = unit_of_key(key); !unit.empty()) text += " (" + std::string(unit) + ')';
    throw_at(written.source(), node, written.str(), text + '?');
  }
  throw_at(node.values().source(), node, key, "is missing; write " + std::string(key) + " = " + wanted);
}

const toml::node& require(TomlNode& node, std::string_view key, const std::string& wanted) {
  const toml::node* const found = node.ask(key);
  if (!found) throw_missing(node, key, wanted);
  return *found;
}

double to_number(const toml::node& found, const TomlNode& node, std::string_view key, const Range& range) {
  if (!found.is_number()) throw_wrong_type(found, node, key, wanted(range));
  const double value =
      found.is_integer() ? static_cast<double>(found.as_integer()->get()) : found.as_floating_point()->get();
  if (!std::isfinite(value)) throw_at(found.source(), node, key, "is not finite; write " + wanted(range));
  if (value < range.low || value > range.high || (range.low_excluded && value == range.low)) {
    throw_at(found.source(), node, key, to_text(value) + " is out of range; write " + wanted(range));
  }
  return value;
}

std::string to_string_value(const toml::node& found, const TomlNode& node, std::string_view key) {
  const auto* const text = found.as_string();
  if (!text) throw_wrong_type(found, node, key, "a text");
  return text->get();
}

/// Lays `over` over `base`. Nodes are moved, because a copied node forgets its position.
void merge(toml::table& base, toml::table&& over) {
  for (auto&& [key, value] : over) {
    toml::table* const inner = value.as_table();
    toml::node* const existing = base.get(key.str());
    toml::table* const base_inner = existing ? existing->as_table() : nullptr;
    if (inner && base_inner) {
      merge(*base_inner, std::move(*inner));
    } else {
      value.visit([&base, &key = key](auto& concrete) { base.insert_or_assign(key, std::move(concrete)); });
    }
  }
}

/// Keys are written bare; one that needs quotes is known to nobody, and toml++ may write it as something that
/// it cannot read again.
bool is_bare(std::string_view key) {
  return !key.empty() && std::ranges::all_of(key, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

void refuse_quoted_keys(const toml::node& node, const std::string& file) {
  if (const toml::array* const array = node.as_array()) {
    for (const toml::node& element : *array) refuse_quoted_keys(element, file);
  }
  const toml::table* const table = node.as_table();
  if (!table) return;
  for (const auto& [key, value] : *table) {
    if (!is_bare(key.str())) {
      throw StartupError(to_text(key.source(), file) +
                         ": a key has other characters than letters, digits, _ and -; correct or remove it");
    }
    refuse_quoted_keys(value, file);
  }
}

toml::table parse(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw StartupError(file.string() + ": there is no such file; check the path (the working directory is " +
                       std::filesystem::current_path(error).string() + ")");
  }
  try {
    toml::table table = toml::parse_file(file.string());
    refuse_quoted_keys(table, file.string());
    return table;
  } catch (const toml::parse_error& problem) {
    throw StartupError(to_text(problem.source(), file.string()) + ": " + std::string(problem.description()) +
                       "; correct this line");
  }
}

toml::table parse(const TomlText& text) {
  try {
    toml::table table = toml::parse(text.text, text.source);
    refuse_quoted_keys(table, text.source);
    return table;
  } catch (const toml::parse_error& problem) {
    throw StartupError(to_text(problem.source(), text.source) + ": " + std::string(problem.description()) +
                       "; correct this text");
  }
}

/// A key that nobody asked for.
struct Unknown {
  const TomlNode* node = nullptr;
  const toml::key* key = nullptr;
  bool is_table = false;
};

/// The order in which a reader of the files meets them: by file, line and column.
bool comes_before(const Unknown& a, const Unknown& b) {
  const auto position = [](const Unknown& unknown) {
    const auto& source = unknown.key->source();
    return std::tuple(source.path && *source.path != unknown.node->file, source.begin.line,
                      source.begin.column);
  };
  return position(a) < position(b);
}

void find_unknown(TomlNode& node, Unknown& first) {
  for (const auto& [key, value] : node.values()) {
    if (!node.asked.contains(key.str())) {
      const Unknown found{&node, &key, value.is_table()};
      if (!first.key || comes_before(found, first)) first = found;
    } else if (const toml::table* const inner = value.as_table()) {
      find_unknown(node.child(key.str(), inner), first);
    }
  }
}

}  // namespace

double TomlTable::number(std::string_view key, Range range) const {
  return to_number(require(*node_, key, wanted(range)), *node_, key, range);
}

double TomlTable::number_or(std::string_view key, double fallback, Range range) const {
  return has(key) ? number(key, range) : fallback;
}

std::int64_t TomlTable::integer(std::string_view key, IntegerRange range) const {
  const toml::node& found = require(*node_, key, wanted(range));
  if (!found.is_integer()) throw_wrong_type(found, *node_, key, wanted(range));
  const std::int64_t value = found.as_integer()->get();
  if (value < range.low || value > range.high) {
    throw_at(found.source(), *node_, key, std::to_string(value) + " is out of range; write " + wanted(range));
  }
  return value;
}

std::int64_t TomlTable::integer_or(std::string_view key, std::int64_t fallback, IntegerRange range) const {
  return has(key) ? integer(key, range) : fallback;
}

bool TomlTable::boolean(std::string_view key) const {
  const toml::node& found = require(*node_, key, "true or false");
  if (!found.is_boolean()) throw_wrong_type(found, *node_, key, "true or false");
  return found.as_boolean()->get();
}

bool TomlTable::boolean_or(std::string_view key, bool fallback) const {
  return has(key) ? boolean(key) : fallback;
}

std::string TomlTable::text(std::string_view key) const {
  return to_string_value(require(*node_, key, "\"a text\""), *node_, key);
}

std::string TomlTable::text_or(std::string_view key, std::string_view fallback) const {
  return has(key) ? text(key) : std::string(fallback);
}

std::size_t TomlTable::choice(std::string_view key, std::span<const std::string_view> words) const {
  std::string list;
  for (const auto word : words) list += (list.empty() ? "" : " or ") + in_quotes(word);
  const std::string written = to_string_value(require(*node_, key, list), *node_, key);
  std::size_t index = 0;
  for (const auto word : words) {
    if (word == written) return index;
    ++index;
  }
  fail(key, in_quotes(written) + " is not known; write " + list);
}

std::size_t TomlTable::choice_or(std::string_view key, std::size_t fallback,
                                 std::span<const std::string_view> words) const {
  return has(key) ? choice(key, words) : fallback;
}

Endpoint TomlTable::endpoint(std::string_view key) const {
  const std::string written = to_string_value(require(*node_, key, "\"192.168.90.13:50013\""), *node_, key);
  try {
    return Endpoint::parse(written);
  } catch (const StartupError& error) {
    fail(key, error.what());
  }
}

Endpoint TomlTable::endpoint_or(std::string_view key, Endpoint fallback) const {
  return has(key) ? endpoint(key) : fallback;
}

std::vector<std::string> TomlTable::texts(std::string_view key) const {
  const toml::node& found = require(*node_, key, "[\"a\", \"b\"]");
  const toml::array* const array = found.as_array();
  if (!array) throw_wrong_type(found, *node_, key, "a list of texts");
  std::vector<std::string> values;
  for (const toml::node& element : *array) values.push_back(to_string_value(element, *node_, key));
  return values;
}

std::vector<std::string> TomlTable::texts_or(std::string_view key, std::vector<std::string> fallback) const {
  return has(key) ? texts(key) : std::move(fallback);
}

std::vector<double> TomlTable::numbers(std::string_view key, Range range) const {
  return list(key, std::nullopt, range);
}

std::vector<double> TomlTable::list(std::string_view key, std::optional<std::size_t> count,
                                    Range range) const {
  const std::string what = count ? "a list of " + std::to_string(*count) + " numbers" : "a list of numbers";
  const toml::node& found = require(*node_, key, what);
  const toml::array* const array = found.as_array();
  if (!array) throw_wrong_type(found, *node_, key, what);
  if (count && array->size() != *count) {
    throw_at(found.source(), *node_, key,
             "has " + std::to_string(array->size()) + " elements; write " + what);
  }
  std::vector<double> values;
  values.reserve(array->size());
  for (const toml::node& element : *array) values.push_back(to_number(element, *node_, key, range));
  return values;
}

bool TomlTable::has(std::string_view key) const {
  return node_->ask(key) != nullptr;
}

TomlTable TomlTable::table(std::string_view key) const {
  const toml::node* const found = node_->ask(key);
  const std::string whole = node_->path.empty() ? std::string(key) : node_->path + '.' + std::string(key);
  if (!found) {
    throw_at(node_->values().source(), *node_, "", "the table [" + whole + "] is missing; write it");
  }
  const toml::table* const inner = found->as_table();
  if (!inner) throw_wrong_type(*found, *node_, key, "the table [" + whole + ']');
  return TomlTable{std::shared_ptr<TomlNode>(node_, &node_->child(key, inner))};
}

TomlTable TomlTable::table_or_empty(std::string_view key) const {
  if (has(key)) return table(key);
  return TomlTable{std::shared_ptr<TomlNode>(node_, &node_->child(key, nullptr))};
}

std::vector<TomlTable> TomlTable::tables() const {
  std::vector<TomlTable> tables;
  for (const auto& [key, value] : node_->values()) {
    if (value.is_table()) tables.push_back(table(key.str()));
  }
  return tables;
}

const std::string& TomlTable::name() const {
  return node_->name;
}
const std::string& TomlTable::path() const {
  return node_->path;
}

void TomlTable::fail(std::string_view key, std::string_view why_and_what_to_do) const {
  const toml::node* const found = node_->ask(key);
  throw_at(found ? found->source() : node_->values().source(), *node_, key, why_and_what_to_do);
}

TomlDocument TomlDocument::load(const std::filesystem::path& file,
                                const std::vector<std::filesystem::path>& overlays,
                                const std::vector<TomlText>& texts) {
  auto root = std::make_shared<TomlNode>();
  root->file = file.string();
  root->own = motionlab::parse(file);
  for (const auto& overlay : overlays) merge(root->own, motionlab::parse(overlay));
  for (const auto& text : texts) merge(root->own, motionlab::parse(text));
  return TomlDocument{std::move(root)};
}

TomlDocument TomlDocument::parse(const TomlText& text) {
  auto root = std::make_shared<TomlNode>();
  root->file = text.source;
  root->own = motionlab::parse(text);
  return TomlDocument{std::move(root)};
}

void TomlDocument::refuse_unknown_keys() const {
  Unknown unknown;
  find_unknown(*root_, unknown);
  if (!unknown.key) return;

  const std::string_view written = unknown.key->str();
  const std::vector<std::string> known(unknown.node->asked.begin(), unknown.node->asked.end());
  std::string text = std::string("unknown ") + (unknown.is_table ? "table " : "key ") + std::string(written);
  if (const auto meant = closest_key(written, known)) {
    text += "; did you mean " + *meant;
    if (const auto unit = unit_of_key(*meant); !unit.empty()) text += " (" + std::string(unit) + ')';
    text += '?';
  } else if (known.empty()) {
    text += "; remove it, nothing is known here";
  } else {
    text += "; remove it, or write one of:";
    for (const auto& key : known) text += ' ' + key;
  }
  throw_at(unknown.key->source(), *unknown.node, written, text);
}

std::string TomlDocument::effective() const {
  // Every text on one line and escaped: toml++ writes others that it cannot read again as they were.
  using enum toml::format_flags;
  const auto flags =
      toml::toml_formatter::default_flags & ~(allow_multi_line_strings | allow_literal_strings);
  std::ostringstream text;
  text << toml::toml_formatter{root_->own, flags};
  return text.str();
}

}  // namespace motionlab

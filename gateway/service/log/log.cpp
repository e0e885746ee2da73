#include "gateway/service/log/log.hpp"

#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <syslog.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>

// Where in our sources an entry was made is of no use to its reader.
#define SD_JOURNAL_SUPPRESS_LOCATION
#include <systemd/sd-journal.h>

namespace motionlab::service {
namespace {

constexpr const char* kIdentifier = "motionlab-gateway";

/// What spdlog's message has no place for; set around each call of it.
struct Fields {
  std::string_view source;
  std::string_view code;
};
thread_local Fields fields_now;

int priority(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::critical:
      return LOG_CRIT;
    case spdlog::level::err:
      return LOG_ERR;
    case spdlog::level::warn:
      return LOG_WARNING;
    case spdlog::level::info:
      return LOG_INFO;
    default:
      return LOG_DEBUG;
  }
}

/// Hands each entry to journald with its fields.
class JournalSink final : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& entry) override {
    std::array<std::string, 5> fields{"MESSAGE=" + std::string(entry.payload.begin(), entry.payload.end()),
                                      "PRIORITY=" + std::to_string(priority(entry.level)),
                                      std::string("SYSLOG_IDENTIFIER=") + kIdentifier,
                                      "MOTIONLAB_SOURCE=" + std::string(fields_now.source),
                                      "MOTIONLAB_CODE=" + std::string(fields_now.code)};
    std::array<iovec, fields.size()> parts{};
    for (std::size_t i = 0; i < fields.size(); ++i) parts[i] = {fields[i].data(), fields[i].size()};
    // A journal that cannot be written has nobody left to be told.
    (void)sd_journal_sendv(parts.data(), static_cast<int>(parts.size()));
  }
  void flush_() override {}
};

bool stderr_is_the_journal() {
  const char* const stream = std::getenv("JOURNAL_STREAM");
  struct stat here {};
  if (!stream || fstat(STDERR_FILENO, &here) != 0) return false;
  return std::to_string(here.st_dev) + ':' + std::to_string(here.st_ino) == stream;
}

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::info:
      return spdlog::level::info;
    case LogLevel::warning:
      return spdlog::level::warn;
    case LogLevel::error:
      break;
  }
  return spdlog::level::err;
}

}  // namespace

void open_log() {
  if (stderr_is_the_journal()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>(kIdentifier, std::make_shared<JournalSink>()));
  } else {
    spdlog::set_default_logger(spdlog::stderr_color_mt(kIdentifier));
    spdlog::set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
  }
}

void set_log_level(LogLevel level) {
  spdlog::set_level(spdlog_level(level));
}

void say(LogLevel level, std::string_view source, std::string_view code, std::string_view text) {
  fields_now = {source, code};
  spdlog::log(spdlog_level(level), "{}", text);
  fields_now = {};
}

}  // namespace motionlab::service

/// @file  The service's log: the journal with fields when systemd started us, else coloured lines on stderr.
#pragma once

#include <string_view>

#include "gateway/service/gateway_config.hpp"

namespace motionlab::service {

/// Chooses where the log goes. Once, before anything is said. stderr counts as the journal when it is the
/// very stream that $JOURNAL_STREAM names.
void open_log();

/// Lets through what is at least so grave.
void set_log_level(LogLevel level);

/// One entry. In the journal it has the fields MESSAGE, PRIORITY, SYSLOG_IDENTIFIER, MOTIONLAB_SOURCE and
/// MOTIONLAB_CODE.
/// @param source  a device or a part of the gateway
/// @param code    stable, for programs
void say(LogLevel level, std::string_view source, std::string_view code, std::string_view text);

}  // namespace motionlab::service

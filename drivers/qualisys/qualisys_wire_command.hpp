/// @file  The commands of the protocol's text interface, as a server reads them.
/// Source: QTM RT Protocol documentation, "Commands".
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "drivers/core/result.hpp"
#include "drivers/qualisys/qualisys_wire_component.hpp"

namespace motionlab::qualisys {

/// The groups of settings that have content here; the others may be asked for and leave nothing.
struct ParameterGroups {
  bool general = false;
  bool bodies = false;   ///< `6D`
  bool markers = false;  ///< `3D`
  bool operator==(const ParameterGroups&) const = default;
};

namespace command {

struct Version {
  std::optional<int> minor;  ///< of `Version 1.n`; empty: which one is in use? -1: no version of the form 1.n
};
struct QtmVersion {};
struct ByteOrder {};
struct GetState {};
struct GetParameters {
  ParameterGroups groups;
};
struct GetCurrentFrame {
  Components components;
};
struct StreamFrames {
  struct Udp {
    std::uint32_t address = 0;  ///< 0: the client's own
    std::uint16_t port = 0;     ///< 1023 or more
  };
  std::uint64_t divisor = 1;      ///< every n-th frame …
  std::optional<double> rate_hz;  ///< … or about so many a second
  std::optional<Udp> udp;         ///< empty: over the connection
  Components components;
};
struct StopStream {};
struct TakeControl {
  std::string_view password;
};
struct ReleaseControl {};
struct New {};
struct Close {};
struct Start {
  bool from_file = false;
};
struct Stop {};
struct Trigger {};
struct SetEvent {
  std::string_view label;
};

}  // namespace command

using Command =
    std::variant<command::Version, command::QtmVersion, command::ByteOrder, command::GetState,
                 command::GetParameters, command::GetCurrentFrame, command::StreamFrames, command::StopStream,
                 command::TakeControl, command::ReleaseControl, command::New, command::Close, command::Start,
                 command::Stop, command::Trigger, command::SetEvent>;

/// Reads a command, in any case of letters and with any number of blanks between its words. Views point into
/// `text`. Fault: refused, for all that is no command or has wrong arguments. Never throws or allocates.
[[nodiscard]] Result<Command> parse_command(std::string_view text) noexcept;

}  // namespace motionlab::qualisys

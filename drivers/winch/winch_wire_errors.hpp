/// @file  ADS error codes: name, meaning and what a client should do about it.
/// Source: Beckhoff "ADS return codes"; classes are ours.
#pragma once

#include <cstdint>
#include <string_view>

namespace motionlab::winch {

namespace ads_error {
inline constexpr std::uint32_t none = 0;
inline constexpr std::uint32_t mailbox_full = 0x004;
inline constexpr std::uint32_t port_not_found = 0x006;
inline constexpr std::uint32_t machine_not_found = 0x007;
inline constexpr std::uint32_t invalid_length = 0x00E;
inline constexpr std::uint32_t invalid_net_id = 0x00F;
inline constexpr std::uint32_t router_mailbox_full = 0x502;
inline constexpr std::uint32_t service_not_supported = 0x701;
inline constexpr std::uint32_t invalid_index_group = 0x702;
inline constexpr std::uint32_t invalid_index_offset = 0x703;
inline constexpr std::uint32_t access_denied = 0x704;
inline constexpr std::uint32_t invalid_size = 0x705;
inline constexpr std::uint32_t invalid_data = 0x706;
inline constexpr std::uint32_t not_ready = 0x707;
inline constexpr std::uint32_t busy = 0x708;
inline constexpr std::uint32_t not_found = 0x70C;
inline constexpr std::uint32_t symbol_not_found = 0x710;
inline constexpr std::uint32_t symbol_version_invalid = 0x711;
inline constexpr std::uint32_t invalid_state = 0x712;
inline constexpr std::uint32_t notification_handle_invalid = 0x714;
inline constexpr std::uint32_t no_more_handles = 0x716;
inline constexpr std::uint32_t symbol_not_active = 0x722;
inline constexpr std::uint32_t client_timeout = 0x745;
}  // namespace ads_error

/// What a client does about an error.
enum class ErrorClass : std::uint8_t {
  none,             ///< no error
  offline,          ///< the PLC runtime is not there: try again slowly
  configuration,    ///< addresses or rights are wrong: people must act
  back_off,         ///< too many requests per cycle
  programming,      ///< we sent nonsense
  resolve_again,    ///< handles or offsets are void: resolve once more
  layout,           ///< sizes differ: stop, do not try again
  retry,            ///< not now
  wrong_project,    ///< the symbols are not in this PLC project: try again slowly, report
  not_running,      ///< the PLC is stopped
  subscribe_again,  ///< the notification is gone
  leak,             ///< handles used up: delete old ones
  timeout,          ///< no answer; never sent by a server
  unknown,          ///< not in the table
};

struct AdsError {
  std::uint32_t code;
  std::string_view name;
  std::string_view text;  ///< what it means and what to do
  ErrorClass error_class;
};

/// The entry of a code; one of class `unknown` for codes that are not in the table.
[[nodiscard]] const AdsError& describe(std::uint32_t code) noexcept;

}  // namespace motionlab::winch

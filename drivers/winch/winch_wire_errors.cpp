#include "drivers/winch/winch_wire_errors.hpp"

#include <algorithm>
#include <array>

namespace motionlab::winch {

namespace {

constexpr std::array kErrors = {
    AdsError{ads_error::none, "none", "no error", ErrorClass::none},
    AdsError{ads_error::mailbox_full, "mailbox full", "too many ADS messages per cycle; ask less often",
             ErrorClass::back_off},
    AdsError{ads_error::port_not_found, "target port not found",
             "the PLC runtime is not started; log in with TwinCAT and set it to run", ErrorClass::offline},
    AdsError{ads_error::machine_not_found, "target machine not found",
             "no such AMS NetId there; compare the configured NetId with the controller's",
             ErrorClass::configuration},
    AdsError{ads_error::invalid_length, "invalid AMS length", "malformed request", ErrorClass::programming},
    AdsError{ads_error::invalid_net_id, "invalid AMS NetId", "malformed address", ErrorClass::programming},
    AdsError{ads_error::router_mailbox_full, "router mailbox full", "too many ADS messages; ask less often",
             ErrorClass::back_off},
    AdsError{ads_error::service_not_supported, "service not supported", "this port does not know the command",
             ErrorClass::programming},
    AdsError{ads_error::invalid_index_group, "invalid index group", "resolve the symbol again",
             ErrorClass::resolve_again},
    AdsError{ads_error::invalid_index_offset, "invalid index offset", "resolve the symbol again",
             ErrorClass::resolve_again},
    AdsError{ads_error::access_denied, "access not permitted",
             "the controller refuses access; check its rights", ErrorClass::configuration},
    AdsError{ads_error::invalid_size, "size wrong", "the PLC's struct has another size than ours",
             ErrorClass::layout},
    AdsError{ads_error::invalid_data, "invalid data", "the device refuses these values",
             ErrorClass::programming},
    AdsError{ads_error::not_ready, "not ready", "the device is not ready yet", ErrorClass::retry},
    AdsError{ads_error::busy, "busy", "the device is busy", ErrorClass::retry},
    AdsError{ads_error::not_found, "not found", "the PLC project lacks this object",
             ErrorClass::wrong_project},
    AdsError{ads_error::symbol_not_found, "symbol not found", "the PLC project lacks this symbol",
             ErrorClass::wrong_project},
    AdsError{ads_error::symbol_version_invalid, "symbol version invalid",
             "the PLC was changed online; resolve again", ErrorClass::resolve_again},
    AdsError{ads_error::invalid_state, "invalid state", "the PLC is stopped; set it to run",
             ErrorClass::not_running},
    AdsError{ads_error::notification_handle_invalid, "notification handle invalid", "subscribe again",
             ErrorClass::subscribe_again},
    AdsError{ads_error::no_more_handles, "no more handles", "old notifications were never deleted",
             ErrorClass::leak},
    AdsError{ads_error::symbol_not_active, "symbol not active", "the PLC was changed online; resolve again",
             ErrorClass::resolve_again},
    AdsError{ads_error::client_timeout, "timeout", "no answer in time", ErrorClass::timeout},
};

constexpr AdsError kUnknown{0xFFFFFFFF, "unknown", "not in our table; see Beckhoff's ADS return codes",
                            ErrorClass::unknown};

}  // namespace

const AdsError& describe(std::uint32_t code) noexcept {
  const auto found =
      std::find_if(kErrors.begin(), kErrors.end(), [&](const AdsError& e) { return e.code == code; });
  return found != kErrors.end() ? *found : kUnknown;
}

}  // namespace motionlab::winch

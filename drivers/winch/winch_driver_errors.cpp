#include "drivers/winch/winch_driver_errors.hpp"

#include <array>
#include <cstdio>
#include <string_view>

namespace motionlab::winch {

namespace {

std::string_view name_of(AdsCommand command) noexcept {
  switch (command) {
    case AdsCommand::read_device_info:
      return "ReadDeviceInfo";
    case AdsCommand::read:
      return "Read";
    case AdsCommand::write:
      return "Write";
    case AdsCommand::read_state:
      return "ReadState";
    case AdsCommand::write_control:
      return "WriteControl";
    case AdsCommand::add_notification:
      return "AddDeviceNotification";
    case AdsCommand::delete_notification:
      return "DeleteDeviceNotification";
    case AdsCommand::notification:
      return "DeviceNotification";
    case AdsCommand::read_write:
      return "ReadWrite";
  }
  return "a request";
}

std::string number(std::uint32_t code) {
  std::array<char, 32> text{};
  (void)std::snprintf(text.data(), text.size(), "0x%X (%u)", code, code);
  return text.data();
}

}  // namespace

std::string to_sentence(const ErrorReport& report) {
  if (report.level == ErrorLevel::drive) {
    return "drive: winch drive or axis fault " + number(report.code) +
           ": read the diagnosis, remove the cause, then reset";
  }
  const AdsError& known = describe(report.code);
  std::string text = report.level == ErrorLevel::router ? "AMS router: " : "ADS device: ";
  text += name_of(report.command);
  text += " was answered with " + number(report.code) + ", ";
  text += known.name;
  text += ": ";
  text += known.text;
  return text;
}

}  // namespace motionlab::winch

#include <algorithm>

#include "drivers/winch/winch_driver.hpp"
#include "drivers/winch/winch_driver_advice.hpp"
#include "drivers/winch/winch_driver_status.hpp"

namespace motionlab::winch {

namespace {

constexpr std::size_t kResultSize = sizeof(std::uint32_t);
constexpr std::size_t kReads = kLegacyStatusNames.size();
constexpr std::size_t kWrites = kLegacyCommandNames.size();
constexpr Fault kOddAnswer{Reason::bad_header, "the answer to a sum command does not fit the question"};

std::string_view name_of(std::size_t i) noexcept {
  return i < kReads ? kLegacyStatusNames[i] : kLegacyCommandNames[i - kReads];
}

/// The first error among the results at the beginning of a sum's answer.
std::uint32_t first_error(Bytes answer, std::size_t n, std::size_t stride) noexcept {
  for (std::size_t i = 0; i < n; ++i) {
    const auto result = load<std::uint32_t, std::endian::little>(answer.subspan(i * stride));
    if (result != ads_error::none) return result;
  }
  return ads_error::none;
}

}  // namespace

/// All names in one sum. Without leave to command we do not even ask for what can be written.
void WinchDriver::ask_legacy_handles() {
  const auto n = static_cast<std::uint32_t>(config_.commands() ? kReads + kWrites : kReads);
  std::array<std::uint8_t, 640> bytes{};
  LittleWriter writer{bytes};
  for (std::size_t i = 0; i < n; ++i) {
    SumReadWriteItem{index_group::handle_by_name, 0, kResultSize,
                     static_cast<std::uint32_t>(name_of(i).size())}
        .encode(writer);
  }
  for (std::size_t i = 0; i < n; ++i) writer.write_bytes(as_bytes(name_of(i)));
  const auto length = static_cast<std::uint32_t>(n * (2 * kResultSize + kResultSize));
  request(Purpose::set_up, AdsCommand::read_write,
          ReadWriteRequest{index_group::sum_read_write, n, length, writer.written()});
}

bool WinchDriver::take_legacy_handles(const AmsFrame& frame) {
  const std::size_t n = config_.commands() ? kReads + kWrites : kReads;
  const auto answer = ReadResponse::decode(frame.data);
  if (!answer) {
    health_.rejected(answer.fault());
    lose_link(advice::kMalformed, now_);
    return false;
  }
  std::uint32_t error = answer->result;
  if (error == ads_error::none && answer->data.size() >= n * 2 * kResultSize) {
    error = first_error(answer->data, n, 2 * kResultSize);
  }
  if (error != ads_error::none) {
    take_error(ErrorLevel::device, error, Purpose::set_up, AdsCommand::read_write);
    return false;
  }
  if (answer->data.size() != n * 3 * kResultSize) {
    health_.rejected(kOddAnswer);
    lose_link(advice::kMalformed, now_);
    return false;
  }
  LittleReader handles{answer->data.subspan(n * 2 * kResultSize)};
  for (std::size_t i = 0; i < n; ++i) legacy_handles_[i] = handles.read<std::uint32_t>();
  heartbeat_.restart(0);
  return true;
}

void WinchDriver::release_legacy_handles() {
  std::array<std::uint8_t, (kReads + kWrites) * (kSumItemSize + kResultSize)> bytes{};
  LittleWriter writer{bytes};
  const auto n = static_cast<std::uint32_t>(
      std::count_if(legacy_handles_.begin(), legacy_handles_.end(), [](auto h) { return h != 0; }));
  if (n == 0) return;
  for (std::uint32_t i = 0; i < n; ++i) {
    SumItem{index_group::release_handle, 0, kResultSize}.encode(writer);
  }
  for (const auto handle : legacy_handles_) {
    if (handle != 0) writer.write(handle);
  }
  request(Purpose::clean_up, AdsCommand::read_write,
          ReadWriteRequest{index_group::sum_write, n, static_cast<std::uint32_t>(n * kResultSize),
                           writer.written()});
  legacy_handles_ = {};
}

void WinchDriver::read_legacy() {
  std::array<std::uint8_t, kReads * kSumItemSize> bytes{};
  LittleWriter writer{bytes};
  for (std::size_t i = 0; i < kReads; ++i) {
    SumItem{index_group::value_by_handle, legacy_handles_[i], kLegacyStatusSizes[i]}.encode(writer);
  }
  constexpr auto kLength = static_cast<std::uint32_t>(kReads * kResultSize + kLegacyStatusSize);
  request(Purpose::read_status, AdsCommand::read_write,
          ReadWriteRequest{index_group::sum_read, kReads, kLength, writer.written()});
}

void WinchDriver::take_legacy_status(Bytes answer, const Request& asked, LabTime t) {
  if (answer.size() != kReads * kResultSize + kLegacyStatusSize) {
    health_.rejected(kOddAnswer);
    return;
  }
  if (const auto error = first_error(answer, kReads, kResultSize)) {
    take_error(ErrorLevel::device, error, asked.purpose, asked.command);
    return;
  }
  const auto status = LegacyStatus::decode(answer.subspan(kReads * kResultSize));
  if (!status) {
    health_.rejected(status.fault());
    return;
  }
  const LabTime t_asked = asked.t_sent - from_seconds(config_.latency_s);
  PlcStatus ours = from_legacy(*status, t_asked, heartbeat_.echo(), config_.legacy_travel_m);
  ours.ready = ours.ready && config_.commands();  // what may not be moved is not ready to be engaged
  accept(ours, t);
}

void WinchDriver::write_legacy(const PlcCommand& command) {
  std::array<std::uint8_t, kWrites * kSumItemSize + kLegacyCommandSize> bytes{};
  LittleWriter writer{bytes};
  for (std::size_t i = 0; i < kWrites; ++i) {
    SumItem{index_group::value_by_handle, legacy_handles_[kReads + i], kLegacyCommandSizes[i]}.encode(writer);
  }
  to_legacy(command, config_.legacy_speed_max_mps).encode(writer);
  request(Purpose::write_command, AdsCommand::read_write,
          ReadWriteRequest{index_group::sum_write, kWrites, kWrites * kResultSize, writer.written()});
}

/// The project echoes nothing: an acknowledged write is all that we learn of the command's way.
void WinchDriver::take_legacy_written(Bytes answer) {
  if (answer.size() != kWrites * kResultSize) {
    health_.rejected(kOddAnswer);
    return;
  }
  if (const auto error = first_error(answer, kWrites, kResultSize)) {
    take_error(ErrorLevel::device, error, Purpose::write_command, AdsCommand::read_write);
    return;
  }
  heartbeat_.echoed(heartbeat_.last());
}

}  // namespace motionlab::winch

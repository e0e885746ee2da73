/// @file  ADS commands: the data of every request and every response, both directions.
///
/// Each message has `encode` and `decode`. Byte spans inside a message are views: of the caller's bytes when
/// encoding, of the frame when decoding. Decoding faults: too_short, too_long (bytes left over or missing
/// against the message's own lengths). A response whose result is an error may lack the rest: it then decodes
/// to zeros. Source: Beckhoff "ADS commands" (tc3_ads_intro 115880971).
#pragma once

#include <cstdint>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/text.hpp"
#include "drivers/core/time.hpp"

namespace motionlab::winch {

enum class AdsCommand : std::uint16_t {
  read_device_info = 1,
  read = 2,
  write = 3,
  read_state = 4,
  write_control = 5,
  add_notification = 6,
  delete_notification = 7,
  notification = 8,
  read_write = 9,
};

/// State of an ADS device. Only `run` moves a winch.
enum class AdsState : std::uint16_t {
  invalid,
  idle,
  reset,
  init,
  start,
  run,
  stop,
  save_config,
  load_config,
  power_failure,
  power_good,
  error,
  shutdown,
  suspend,
  resume,
  config,
  reconfig,
  stopping,
  incompatible,
  exception,
};

namespace index_group {
inline constexpr std::uint32_t plc_memory = 0x4020;
inline constexpr std::uint32_t plc_data = 0x4040;
inline constexpr std::uint32_t handle_by_name = 0xF003;
inline constexpr std::uint32_t value_by_name = 0xF004;
inline constexpr std::uint32_t value_by_handle = 0xF005;
inline constexpr std::uint32_t release_handle = 0xF006;
inline constexpr std::uint32_t info_by_name = 0xF007;
inline constexpr std::uint32_t symbol_version = 0xF008;
inline constexpr std::uint32_t info_by_name_ex = 0xF009;
inline constexpr std::uint32_t upload = 0xF00B;
inline constexpr std::uint32_t upload_info = 0xF00C;
inline constexpr std::uint32_t upload_types = 0xF00E;
inline constexpr std::uint32_t upload_info_2 = 0xF00F;
inline constexpr std::uint32_t type_by_name = 0xF011;
inline constexpr std::uint32_t sum_read = 0xF080;
inline constexpr std::uint32_t sum_write = 0xF081;
inline constexpr std::uint32_t sum_read_write = 0xF082;
inline constexpr std::uint32_t sum_read_ex = 0xF083;    ///< with the length of each item in front
inline constexpr std::uint32_t sum_read_ex_2 = 0xF084;  ///< likewise; failed items have no data
inline constexpr std::uint32_t sum_add_notification = 0xF085;
inline constexpr std::uint32_t sum_delete_notification = 0xF086;
inline constexpr std::uint32_t device_data = 0xF100;
inline constexpr std::uint32_t system_state_ex = 0x00F0;  ///< on the system service's port only
}  // namespace index_group

/// When a server sends a notification.
enum class NotificationMode : std::uint32_t { none = 0, cyclic = 3, on_change = 4 };

// Requests

struct ReadRequest {
  std::uint32_t index_group = 0;
  std::uint32_t index_offset = 0;
  std::uint32_t length = 0;  ///< most bytes wanted; may be absurdly large, never size a buffer from it

  bool operator==(const ReadRequest&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<ReadRequest> decode(Bytes data) noexcept;
};

struct WriteRequest {
  std::uint32_t index_group = 0;
  std::uint32_t index_offset = 0;
  Bytes data{};

  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<WriteRequest> decode(Bytes data) noexcept;
};

struct ReadWriteRequest {
  std::uint32_t index_group = 0;
  std::uint32_t index_offset = 0;
  std::uint32_t read_length = 0;  ///< as ReadRequest::length
  Bytes data{};

  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<ReadWriteRequest> decode(Bytes data) noexcept;
};

struct WriteControlRequest {
  AdsState ads_state{};
  std::uint16_t device_state = 0;
  Bytes data{};

  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<WriteControlRequest> decode(Bytes data) noexcept;
};

struct AddNotificationRequest {
  std::uint32_t index_group = 0;
  std::uint32_t index_offset = 0;
  std::uint32_t length = 0;
  std::uint32_t mode = 0;    ///< a NotificationMode, or one that we do not serve
  Nanoseconds max_delay{0};  ///< whole 100 ns on the wire
  Nanoseconds cycle_time{0};

  bool operator==(const AddNotificationRequest&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<AddNotificationRequest> decode(Bytes data) noexcept;
};

struct DeleteNotificationRequest {
  std::uint32_t handle = 0;

  bool operator==(const DeleteNotificationRequest&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<DeleteNotificationRequest> decode(Bytes data) noexcept;
};

// Responses. `result` is the ADS device's own answer; look at the AMS header's error first.

/// Of Write, WriteControl and DeleteDeviceNotification.
struct ResultResponse {
  std::uint32_t result = 0;

  bool operator==(const ResultResponse&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<ResultResponse> decode(Bytes data) noexcept;
};

/// Of Read and ReadWrite.
struct ReadResponse {
  std::uint32_t result = 0;
  Bytes data{};

  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<ReadResponse> decode(Bytes data) noexcept;
};

struct ReadStateResponse {
  std::uint32_t result = 0;
  AdsState ads_state{};
  std::uint16_t device_state = 0;

  bool operator==(const ReadStateResponse&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<ReadStateResponse> decode(Bytes data) noexcept;
};

struct DeviceInfoResponse {
  std::uint32_t result = 0;
  std::uint8_t major = 0;
  std::uint8_t minor = 0;
  std::uint16_t build = 0;
  Text<16> name{};

  bool operator==(const DeviceInfoResponse&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<DeviceInfoResponse> decode(Bytes data) noexcept;
};

struct AddNotificationResponse {
  std::uint32_t result = 0;
  std::uint32_t handle = 0;

  bool operator==(const AddNotificationResponse&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<AddNotificationResponse> decode(Bytes data) noexcept;
};

// Sum commands: several reads or writes in one request. The number of items is the request's index offset.

inline constexpr std::size_t kSumItemSize = 12;
inline constexpr std::uint32_t kSumItemsMax = 500;  ///< the vendor's advice, our limit

/// One entry of a sum read or sum write list: what, and how many bytes.
using SumItem = ReadRequest;

/// The n-th entry. @pre data holds at least (n + 1) entries
[[nodiscard]] SumItem sum_item(Bytes data, std::size_t n) noexcept;

inline constexpr std::size_t kSumReadWriteItemSize = 16;
inline constexpr std::size_t kSumSubscribeItemSize = 40;  ///< an AddNotificationRequest each

/// One entry of a sum read/write list; the data to write follow behind the whole list.
struct SumReadWriteItem {
  std::uint32_t index_group = 0;
  std::uint32_t index_offset = 0;
  std::uint32_t read_length = 0;
  std::uint32_t write_length = 0;

  bool operator==(const SumReadWriteItem&) const = default;
  void encode(LittleWriter& writer) const noexcept;
};

/// The n-th entry. @pre data holds at least (n + 1) entries
[[nodiscard]] SumReadWriteItem sum_read_write_item(Bytes data, std::size_t n) noexcept;

}  // namespace motionlab::winch

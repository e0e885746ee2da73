/// @file  Our end of the winch: an ADS client on one TCP connection to the PLC.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/core/device_clock.hpp"
#include "drivers/core/link_health.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/sink.hpp"
#include "drivers/winch/winch_driver_arming.hpp"
#include "drivers/winch/winch_driver_backoff.hpp"
#include "drivers/winch/winch_driver_command.hpp"
#include "drivers/winch/winch_driver_config.hpp"
#include "drivers/winch/winch_driver_errors.hpp"
#include "drivers/winch/winch_driver_liveness.hpp"
#include "drivers/winch/winch_driver_requests.hpp"
#include "drivers/winch/winch_wire.hpp"
#include "idl/winch_command.hpp"
#include "idl/winch_state.hpp"

namespace motionlab::winch {

/// Commands the winch and tells its state.
///
/// Connects, checks that the PLC runs and that both structs have the size, type and version we know, then
/// writes the whole command every period and hears the whole status by cyclic notification. Lengths on topics
/// are free wire lengths (see AxisMap). With the profile `legacy` the symbols of MAIN.winch are read every
/// period instead, t_measured is when they were asked for, and nothing is written unless `legacy_commands`
/// allows it: then never faster than `legacy_speed_max_mps`, since that project has no watchdog.
///
/// Time: call `step` about every millisecond. Before the first status nothing is told. A status whose cycle
/// counter does not advance is not told. Without a command, or with one older than `command_stale_after_s`,
/// the winch is told to stop and hold. After every (re)connect the winch stays disabled until the caller's
/// enable rises (see Arming). Faults: counted in `health()`, whose advice says what to do and begins with the
/// level of the trouble; the newest ADS error is in `last_error()`. A layout that is not ours halts the
/// driver for good. It never writes the ADS state of the PLC.
class WinchDriver : public StreamEvents {
 public:
  /// Both references must outlive the driver.
  WinchDriver(DriverConfig config, StreamOut& out, Sink<topic::WinchState> sink);
  WinchDriver(const WinchDriver&) = delete;
  WinchDriver& operator=(const WinchDriver&) = delete;

  /// Takes the newest command. Faults: see CommandSource; then the one in use goes on, and becomes stale.
  Status set_command(const topic::WinchCommand& command);

  void step(LabTime now);

  /// Begins to stop for good: quick stop, wait for rest, disable, delete notifications, release handles,
  /// close. Later commands are ignored. Gives up waiting after some seconds; the PLC's watchdog then does the
  /// rest.
  void orderly_stop();
  [[nodiscard]] bool stopped() const noexcept { return stage_ == Stage::ended; }
  /// The PLC's structs are not the ones we know; people must act, we do not try again.
  [[nodiscard]] bool halted() const noexcept { return stage_ == Stage::halted; }

  void on_open(LabTime t) override;
  void on_bytes(Bytes bytes, LabTime t_received) override;
  void on_closed(std::string_view why, LabTime t) override;

  [[nodiscard]] const LinkHealth& health() const noexcept { return health_; }
  [[nodiscard]] const DeviceClock& clock() const noexcept { return clock_; }
  [[nodiscard]] const RoundTrip& round_trip() const noexcept { return round_trip_; }
  /// What the controller calls itself; empty before the first connection.
  [[nodiscard]] const DeviceInfoResponse& device_info() const noexcept { return device_info_; }
  [[nodiscard]] const std::optional<ErrorReport>& last_error() const noexcept { return errors_.newest(); }

  struct Counters {
    std::uint64_t commands_written = 0;
    std::uint64_t commands_skipped = 0;       ///< ticks at which the last write was still unanswered
    std::uint64_t commands_stale = 0;         ///< times that the caller's command became stale
    std::uint64_t timeouts = 0;               ///< requests without an answer in time
    std::uint64_t status_repeated = 0;        ///< status whose cycle counter had not advanced
    std::uint64_t foreign_notifications = 0;  ///< of a former life of ours; deleted
    std::uint64_t resolved_again = 0;
  };
  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }

 private:
  enum class Stage : std::uint8_t { idle, waiting, opening, setting_up, running, halted, ended };
  enum class Step : std::uint8_t {
    system_state,
    plc_state,
    device_info,
    command_symbol,
    status_symbol,
    command_handle,
    status_handle,
    first_status,
    legacy_handles,
    subscribe_version,
    subscribe_status,
    done,
  };
  enum class Stopping : std::uint8_t { no, braking, disabling, cleaning };

  // winch_driver.cpp: the connection, requests
  void open(LabTime now);
  void lose_link(std::string_view advice, LabTime now);
  void halt(Fault fault);
  void finish();
  void check_timeouts();
  template <class Message>
  void request(Purpose purpose, AdsCommand command, const Message& message, std::uint16_t port = 0);

  // winch_driver_setup.cpp: from a connection to a running winch, and back
  void send_step();
  void take_step(const AmsFrame& frame);
  template <class Response>
  [[nodiscard]] bool answered(const Response& response, const AmsFrame& frame);
  [[nodiscard]] bool take_state(const AmsFrame& frame);
  [[nodiscard]] bool take_symbol(const AmsFrame& frame);
  [[nodiscard]] bool take_handle(const AmsFrame& frame);
  [[nodiscard]] bool take_first_status(const AmsFrame& frame);
  [[nodiscard]] Step next_step() const noexcept;
  [[nodiscard]] Status check_symbol(Bytes answer, std::size_t size, std::string_view type);
  void retry_set_up(std::string_view advice);
  void start_running();
  void resolve_again();
  void delete_notifications();
  void clean_up();

  // winch_driver_running.cpp: commands out
  void write_command();
  void check_status_age();
  void follow_stop();

  // winch_driver_arrivals.cpp: what comes in
  void take_frame(const AmsFrame& frame, LabTime t);
  void take_notification(const AmsFrame& frame, LabTime t);
  void take_sample(const NotificationSample& sample, LabTime t);
  void take_version(Bytes data);
  void take_foreign(std::uint32_t handle);
  void take_answer(const AmsFrame& frame, LabTime t);
  void take_written(const AmsFrame& frame, const Request& asked);
  void take_read(const AmsFrame& frame, const Request& asked, LabTime t);
  void take_error(ErrorLevel level, std::uint32_t code, Purpose purpose, AdsCommand command);
  void take_status(Bytes bytes, LabTime t);
  void accept(const PlcStatus& status, LabTime t);
  void tell(const PlcStatus& status, LabTime t);
  void advise(const PlcStatus& status);

  // winch_driver_legacy.cpp: MAIN.winch in place of GVL_Winch
  void ask_legacy_handles();
  [[nodiscard]] bool take_legacy_handles(const AmsFrame& frame);
  void release_legacy_handles();
  void read_legacy();
  void write_legacy(const PlcCommand& command);
  void take_legacy_status(Bytes answer, const Request& asked, LabTime t);
  void take_legacy_written(Bytes answer);

  DriverConfig config_;
  AxisMap axis_;
  StreamOut& out_;
  Sink<topic::WinchState> sink_;
  LinkHealth health_;
  DeviceClock clock_;
  FrameSplitter splitter_;
  std::array<std::uint8_t, 1024> frame_{};
  std::string advice_route_;
  std::string advice_net_id_;
  std::string advice_error_;  ///< about the newest error

  LabTime now_{};
  Stage stage_ = Stage::idle;
  Step step_ = Step::system_state;
  Stopping stopping_ = Stopping::no;
  LabTime t_stopping_{};
  std::uint32_t stop_heartbeat_ = 0;
  LabTime t_opened_{};
  LabTime retry_at_{};
  bool step_due_ = false;
  Backoff backoff_;
  std::uint64_t opens_ = 0;
  bool heard_anything_ = false;  ///< on this connection
  std::uint32_t timeouts_in_a_row_ = 0;
  std::optional<LabTime> t_resolved_again_;

  RequestTable requests_;
  DeviceInfoResponse device_info_{};
  std::uint32_t command_handle_ = 0;  ///< 0: none. No server gives 0
  std::uint32_t status_handle_ = 0;
  std::uint32_t version_notification_ = 0;
  std::uint32_t status_notification_ = 0;
  std::array<std::uint32_t, kLegacyStatusNames.size() + kLegacyCommandNames.size()> legacy_handles_{};
  std::optional<std::uint8_t> symbol_version_;
  LabTime next_delete_{};

  CommandSource commands_;
  Arming arming_;
  HeartbeatWatch heartbeat_;
  RoundTrip round_trip_;
  PlcCommand written_{};
  LabTime next_command_{};
  bool commands_refused_ = false;  ///< the newest answer to a write was an error

  std::optional<PlcStatus> status_;  ///< newest of this connection
  LabTime t_fresh_{};
  LabTime next_read_{};
  std::uint64_t told_ = 0;
  ErrorLog errors_;
  Counters counters_{};
};

template <class Message>
void WinchDriver::request(Purpose purpose, AdsCommand command, const Message& message, std::uint16_t port) {
  const auto invoke_id = requests_.open(purpose, command, now_);
  if (!invoke_id) return;  // all slots unanswered: the timeouts are about to close the connection
  AmsHeader header;
  header.target = config_.target;
  if (port != 0) header.target.port = port;
  header.source = config_.local;
  header.command = static_cast<std::uint16_t>(command);
  header.invoke_id = *invoke_id;
  const auto frame = encode_frame(frame_, header, message);
  if (!frame) {
    health_.rejected(frame.fault());
    return;
  }
  if (const auto sent = out_.send(*frame); !sent) health_.rejected(sent.fault());
}

}  // namespace motionlab::winch

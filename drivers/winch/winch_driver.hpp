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
#include "drivers/winch/winch_driver_liveness.hpp"
#include "drivers/winch/winch_wire.hpp"
#include "idl/winch_command.hpp"
#include "idl/winch_state.hpp"

namespace motionlab::winch {

struct DriverConfig {
  std::string device = "winch";
  AmsAddress target{{{192, 168, 90, 150, 1, 1}}, ams_port::plc_runtime_1};
  /// Ours. The PLC needs a route to this NetId. One fixed port, so that what we left behind can be found and
  /// deleted.
  AmsAddress local{{{192, 168, 90, 70, 1, 1}}, 32905};
  std::string command_symbol = "GVL_Winch.stCommand";
  std::string status_symbol = "GVL_Winch.stStatus";

  double command_period_s = 0.010;
  double status_period_s = 0.010;
  double command_stale_after_s = 0.05;    ///< an older command becomes quick stop and hold
  double status_stale_after_s = 0.05;     ///< then the status is read, in case only notifications are lost
  double status_dead_after_s = 1.0;       ///< then the connection is closed and made anew
  double heartbeat_echo_within_s = 0.05;  ///< else the command path is not alive
  double request_timeout_s = 0.1;
  double connect_timeout_s = 1.0;
  double reconnect_min_s = 0.1;  ///< doubles up to the next, with jitter
  double reconnect_max_s = 2.0;
  double plc_watchdog_s = 0.1;   ///< wanted of the PLC, which clamps it to 0.02..0.5
  double torque_limit_nm = 0.0;  ///< at the motor; 0: the drive's own
  double latency_s = 0.0;        ///< known constant delay from the PLC's stamp to arrival
  double wire_at_zero_travel_m =
      1.20;                   ///< free wire length where the axis' position is zero; measure on site
  double pay_out_sign = 1.0;  ///< +1 or -1: which way the axis' position grows when wire is paid out
  std::uint32_t jitter_seed = 1;
};

/// Commands the winch and tells its state.
///
/// Connects, checks that the PLC runs and that both structs have the size, type and version we know, then
/// writes the whole command every period and hears the whole status by cyclic notification. Lengths on topics
/// are free wire lengths: wire_length_m = wire_at_zero_travel_m + pay_out_sign * (axis position); speeds,
/// accelerations and limits follow. That mapping is made here and nowhere else.
///
/// Time: call `step` about every millisecond. Before the first status nothing is told. A status whose cycle
/// counter does not advance is not told. Without a command, or with one older than `command_stale_after_s`,
/// the winch is told to stop and hold. After every (re)connect the winch stays disabled until the caller's
/// enable rises (see Arming). Faults: counted in `health()`, whose advice says what to do; the newest ADS
/// error is in `last_error()`. A layout that is not ours halts the driver for good. It never writes the ADS
/// state of the PLC.
class WinchDriver : public StreamEvents {
 public:
  /// Both references must outlive the driver.
  WinchDriver(DriverConfig config, StreamOut& out, Sink<topic::WinchState> sink);
  WinchDriver(const WinchDriver&) = delete;
  WinchDriver& operator=(const WinchDriver&) = delete;

  /// Takes the newest command. Its age counts from t_created_ns, or from now when that lies ahead.
  /// Faults: bad_value (not finite), out_of_order (created before the one in use), foreign (another device's
  /// name); then the one in use goes on, and becomes stale.
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

  /// Level, place and number of the newest ADS error, for people.
  struct ErrorReport {
    enum class Level : std::uint8_t { ams, ads } level{};
    std::uint32_t code = 0;  ///< see describe()
    AdsCommand command{};
    LabTime t_first{};
    LabTime t_last{};
    std::uint64_t count = 0;
  };
  [[nodiscard]] const std::optional<ErrorReport>& last_error() const noexcept { return last_error_; }

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
    subscribe_version,
    subscribe_status,
    done,
  };
  enum class Stopping : std::uint8_t { no, braking, disabling, cleaning };
  enum class Purpose : std::uint8_t { none, set_up, write_command, read_status, clean_up };
  struct Pending {
    Purpose purpose = Purpose::none;
    AdsCommand command{};
    std::uint32_t invoke_id = 0;
    LabTime t_sent{};
  };

  void open(LabTime now);
  void lose_link(std::string_view advice, LabTime now);
  void retry_set_up(std::string_view advice);
  void halt(Fault fault);
  void finish();

  void send_step();
  void take_step(const AmsFrame& frame);
  [[nodiscard]] Status check_symbol(Bytes answer, std::size_t size, std::string_view type);
  void start_running();
  void resolve_again();
  void delete_notifications();
  void clean_up();

  void check_timeouts();
  void check_status_age();
  void write_command();
  [[nodiscard]] PlcCommand command_for(Arming::Bits bits);
  void follow_stop();

  void take_frame(const AmsFrame& frame, LabTime t);
  void take_notification(const AmsFrame& frame, LabTime t);
  void take_answer(const AmsFrame& frame, LabTime t);
  void take_error(ErrorReport::Level level, std::uint32_t code, Purpose purpose, AdsCommand command);
  void take_status(Bytes bytes, LabTime t);
  void tell(const PlcStatus& status, LabTime t);
  void advise(const PlcStatus& status);

  template <class Message>
  void request(Purpose purpose, AdsCommand command, const Message& message, std::uint16_t port = 0);
  [[nodiscard]] bool waiting_for(Purpose purpose) const noexcept;
  [[nodiscard]] double to_axis(double wire_length_m) const noexcept;
  [[nodiscard]] double to_wire(double position_m) const noexcept;

  DriverConfig config_;
  StreamOut& out_;
  Sink<topic::WinchState> sink_;
  LinkHealth health_;
  DeviceClock clock_;
  FrameSplitter splitter_;
  std::array<std::uint8_t, 512> frame_{};
  std::string advice_route_;
  std::string advice_net_id_;

  LabTime now_{};
  Stage stage_ = Stage::idle;
  Step step_ = Step::system_state;
  Stopping stopping_ = Stopping::no;
  LabTime t_stopping_{};
  std::uint32_t stop_heartbeat_ = 0;
  LabTime t_opened_{};
  LabTime retry_at_{};
  bool step_due_ = false;
  double backoff_s_;
  std::uint32_t jitter_;
  std::uint64_t opens_ = 0;
  bool heard_anything_ = false;  ///< on this connection
  std::uint32_t timeouts_in_a_row_ = 0;
  std::optional<LabTime> t_resolved_again_;

  std::array<Pending, 8> pending_{};
  std::uint32_t invoke_id_ = 0;
  DeviceInfoResponse device_info_{};
  std::uint32_t command_handle_ = 0;
  std::uint32_t status_handle_ = 0;
  std::uint32_t version_notification_ = 0;
  std::uint32_t status_notification_ = 0;
  std::optional<std::uint8_t> symbol_version_;
  LabTime next_delete_{};

  topic::WinchCommand command_{};
  std::optional<LabTime> t_command_;
  bool command_stale_ = false;
  Arming arming_;
  HeartbeatWatch heartbeat_;
  RoundTrip round_trip_;
  PlcCommand written_{};
  LabTime next_command_{};

  std::optional<PlcStatus> status_;  ///< newest of this connection
  LabTime t_fresh_{};
  LabTime next_read_{};
  std::uint64_t told_ = 0;
  std::optional<ErrorReport> last_error_;
  Counters counters_{};
};

}  // namespace motionlab::winch

/// @file  The simulated winch controller: an ADS server on TCP in front of the PLC program.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "drivers/core/network.hpp"
#include "drivers/core/random.hpp"
#include "drivers/winch/winch_wire.hpp"
#include "simulators/faults/common_faults.hpp"
#include "simulators/winch/winch_device_legacy.hpp"
#include "simulators/winch/winch_device_plc.hpp"
#include "simulators/winch/winch_device_symbols.hpp"

namespace motionlab::winch {

struct DeviceConfig {
  NetId net_id{{192, 168, 90, 150, 1, 1}};
  std::uint16_t plc_port = ams_port::plc_runtime_1;
  /// NetIds with a route to this machine; frames of others close their connection. Empty: every NetId has
  /// one.
  std::vector<NetId> routes{};
  bool one_connection_per_address =
      true;  ///< a second connection from an address closes the first, as TwinCAT does
  PlcProject project = PlcProject::gvl_winch;
  PlcConfig plc{};
  std::uint64_t seed = 1;  ///< of garbage
};

/// An ADS server that behaves to its clients as a TwinCAT controller does.
///
/// Answers ReadState, ReadDeviceInfo, Read, Write, ReadWrite, WriteControl, Add- and DeleteDeviceNotification
/// on the PLC's port, state and device info on the system service's. Symbols: GVL_Winch.stCommand,
/// GVL_Winch.stStatus, their members, and those of MAIN.winch, by name, by handle, by offset and in sums;
/// their entries and types one by one and all at once. Without GVL_Winch (project `legacy`) MAIN.winch is
/// obeyed; with it, it only tells. Notifications belong to an AMS address, not to a connection: those of a
/// client that vanished go on at its next connection. Steady traffic (writes by handle, cyclic notifications)
/// allocates nothing. Source: Beckhoff, ADS specification (tc3_ads_intro 115845259, 115880971).
class WinchDevice : public ServerEvents {
 public:
  WinchDevice(DeviceConfig config, ServerOut& out);

  void on_accepted(SessionId session, Endpoint from, LabTime t) override;
  void on_bytes(SessionId session, Bytes bytes, LabTime t_received) override;
  void on_closed(SessionId session, LabTime t) override;

  /// Sends what was held back. Call about every millisecond.
  void step(LabTime now);
  /// The PLC's task: obeys the command, writes the status, sends the notifications that are due. Every 5 ms.
  void cycle(LabTime t, const Measurement& measurement);

  /// From now on the controller's own clock shows so much more; 0: right again.
  void set_clock_jump(Nanoseconds jump) noexcept { plc_.set_clock_jump(jump); }

  /// Free wire length that the drive holds; see PlcProgram.
  [[nodiscard]] double set_point_m() const noexcept { return plc_.set_point_m(); }
  [[nodiscard]] bool brake_closed() const noexcept { return plc_.brake_closed(); }
  [[nodiscard]] const PlcProgram& plc() const noexcept { return plc_; }
  [[nodiscard]] std::size_t sessions() const noexcept { return sessions_.size(); }
  [[nodiscard]] std::size_t subscriptions() const noexcept { return subscriptions_.size(); }
  [[nodiscard]] std::size_t handles() const noexcept { return handles_.size(); }
  /// Frames and requests that were not understood.
  [[nodiscard]] std::uint64_t malformed() const noexcept { return malformed_; }

  /// Injects or removes a fault. The common ones: `off` also closes the brake and, when it ends, boots the
  /// controller, which knows no handle, no notification and no connection then; `slow` spreads notifications;
  /// `wrong` and `stuck` are of the sensors, the drive itself moves as before. Its own:
  ///   silent           nothing is sent any more
  ///   drop_route       connections are accepted, and closed at their first frame
  ///   stop_plc         the PLC stops; with value 15 it goes to config mode, where its port does not exist
  ///   online_change    the symbol version grows, handles and notifications become void, variables move; once
  ///   frozen_cycle     nCycleCount and nTimestamp stand still
  ///   drive_fault      the drive shuts down; `value` is its S-0-0390 number
  ///   watchdog_trip    the PLC takes the heartbeat for lost
  ///   router_error     requests to the PLC's port are answered with AMS error `value` (default 6)
  ///   ads_error        they are answered with ADS result `value` (default 0x708, busy)
  ///   other_layout     nLayoutVersion of the status is another one
  ///   close_mid_frame  the next frame is cut in half and its connection closed, once
  ///   outlier_100ms    every `value`-th frame (default 50) is 100 ms late, and with it what follows
  /// Refused with the list of names when the name is none of them.
  Status set_fault(std::string_view name, bool active, double value = 0.0);
  /// Every name that `set_fault` knows, separated by blanks.
  [[nodiscard]] static std::string_view fault_names() noexcept;

 private:
  struct Held {
    LabTime due{};
    ByteBuffer bytes;
  };
  struct Session {
    SessionId id = 0;
    Endpoint from{};
    FrameSplitter splitter{};
    std::deque<Held> held{};
  };
  struct Handle {
    std::uint32_t id = 0;
    std::uint32_t symbol = 0;
    bool valid = true;  ///< false after an online change
  };
  struct Client {
    AmsAddress address{};
    SessionId session = 0;
  };
  struct Subscription {
    std::uint32_t handle = 0;
    AmsAddress server{};
    AmsAddress client{};
    SumItem item{};
    NotificationMode mode{};
    Nanoseconds period{0};
    LabTime due{};
    ByteBuffer sent;
  };
  struct Faults {
    faults::CommonFaults common;
    bool silent = false;
    bool drop_route = false;
    bool other_layout = false;
    bool close_mid_frame = false;
    std::uint32_t router_error = ads_error::none;
    std::uint32_t ads_error = ads_error::none;
    std::optional<std::uint64_t> outlier_every;
  };
  /// What lies at an index group and offset: bytes, or an ADS error.
  struct Place {
    std::uint32_t error = ads_error::none;
    Bytes bytes{};
    MutableBytes writable{};
  };

  // winch_device.cpp: connections, time, faults, sending
  [[nodiscard]] Session* find(SessionId id);
  void drop(SessionId id);
  void serve_local(Session& session, const TcpFrame& frame);
  [[nodiscard]] bool has_route(const NetId& source) const;
  [[nodiscard]] std::uint32_t routing_error(const AmsAddress& target) const;
  void remember(const AmsAddress& client, SessionId session);
  void set_state(AdsState state);
  void change_online();
  void power(bool off);
  [[nodiscard]] Measurement seen(const Measurement& is);
  void transmit(Session& session, Bytes frame);
  void send_or_hold(Session& session, Bytes bytes, Nanoseconds delay);

  // winch_device_requests.cpp: one request, one answer
  void serve(Session& session, const AmsFrame& frame);
  void serve_state(Session& session, const AmsFrame& frame);
  void serve_info(Session& session, const AmsFrame& frame);
  void serve_read(Session& session, const AmsFrame& frame);
  void serve_write(Session& session, const AmsFrame& frame);
  void serve_read_write(Session& session, const AmsFrame& frame);
  void serve_control(Session& session, const AmsFrame& frame);
  void serve_subscribe(Session& session, const AmsFrame& frame);
  void serve_unsubscribe(Session& session, const AmsFrame& frame);
  template <class Message>
  void answer(Session& session, const AmsHeader& request, const Message& message,
              std::uint32_t ams_error = 0);

  // winch_device_values.cpp: what lies where
  [[nodiscard]] Place place(const AmsAddress& server, std::uint32_t group, std::uint32_t offset);
  [[nodiscard]] Place place_by_handle(std::uint32_t id);
  [[nodiscard]] MutableBytes data_area(std::uint32_t offset);
  [[nodiscard]] Bytes system_state();
  [[nodiscard]] std::uint32_t write_value(const AmsAddress& server, std::uint32_t group, std::uint32_t offset,
                                          Bytes data);
  [[nodiscard]] std::uint32_t read_write(const AmsHeader& header, const ReadWriteRequest& request,
                                         LittleWriter& answer);
  [[nodiscard]] std::uint32_t read_by_name(const ReadWriteRequest& request, LittleWriter& answer);
  [[nodiscard]] std::uint32_t give_handle(const SymbolTable::Symbol& symbol, std::uint32_t read_length,
                                          LittleWriter& answer);

  // winch_device_sums.cpp: many requests in one
  [[nodiscard]] bool is_sum(std::uint32_t group) const noexcept;
  [[nodiscard]] std::uint32_t sum(const AmsHeader& header, const ReadWriteRequest& request,
                                  LittleWriter& answer);
  [[nodiscard]] std::uint32_t sum_read(const AmsAddress& server, const ReadWriteRequest& request,
                                       LittleWriter& answer);
  [[nodiscard]] std::uint32_t sum_write(const AmsAddress& server, const ReadWriteRequest& request,
                                        LittleWriter& answer);
  [[nodiscard]] std::uint32_t sum_read_write(const AmsHeader& header, const ReadWriteRequest& request,
                                             LittleWriter& answer);
  [[nodiscard]] std::uint32_t sum_subscribe(const AmsHeader& header, const ReadWriteRequest& request,
                                            LittleWriter& answer);
  [[nodiscard]] std::uint32_t sum_unsubscribe(const AmsHeader& header, const ReadWriteRequest& request,
                                              LittleWriter& answer);

  // winch_device_notifications.cpp
  [[nodiscard]] AddNotificationResponse subscribe(const AmsHeader& header,
                                                  const AddNotificationRequest& request);
  [[nodiscard]] std::uint32_t unsubscribe(const AmsAddress& client, std::uint32_t handle);
  /// The first sample of every subscription that has had none.
  void send_first_samples();
  void notify(LabTime t);
  void send_sample(Subscription& subscription, Bytes value);

  DeviceConfig config_;
  ServerOut& out_;
  PlcProgram plc_;
  LegacyProgram legacy_;
  SymbolTable symbols_;
  Random random_;
  AdsState state_ = AdsState::run;
  std::uint8_t symbol_version_ = 1;
  std::uint32_t data_at_ = 0;  ///< where the data area begins: every build has another place for it
  std::vector<Handle> handles_;
  std::uint32_t next_handle_ = 1;
  std::uint32_t next_subscription_ = 1;
  std::uint16_t next_port_ = 32768;
  std::vector<Session> sessions_;
  std::vector<Client> clients_;
  std::vector<Subscription> subscriptions_;
  Faults faults_{};
  std::optional<Measurement> stuck_at_;
  std::uint64_t frames_sent_ = 0;
  std::uint64_t malformed_ = 0;
  LabTime now_{};
  std::array<std::uint8_t, 24> scratch_{};  ///< values that are made when asked for
  ByteBuffer data_;                         ///< data of the answer under construction
  ByteBuffer item_;                         ///< one item of a sum
  ByteBuffer frame_;                        ///< its frame
};

}  // namespace motionlab::winch

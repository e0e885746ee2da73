/// @file  The simulated winch controller: an ADS server on TCP in front of the PLC program.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/network.hpp"
#include "drivers/winch/winch_wire.hpp"
#include "simulators/winch/winch_device_plc.hpp"

namespace motionlab::winch {

struct DeviceConfig {
  NetId net_id{{192, 168, 90, 150, 1, 1}};
  std::uint16_t plc_port = ams_port::plc_runtime_1;
  /// NetIds with a route to this machine; frames of others close their connection. Empty: every NetId has
  /// one.
  std::vector<NetId> routes{};
  bool one_connection_per_address =
      true;  ///< a second connection from an address closes the first, as TwinCAT does
  PlcConfig plc{};
};

/// An ADS server that behaves to its clients as a TwinCAT controller does.
///
/// Answers ReadState, ReadDeviceInfo, Read, Write, ReadWrite, WriteControl, Add- and DeleteDeviceNotification
/// on the PLC's port, state and device info on the system service's. Symbols: GVL_Winch.stCommand,
/// GVL_Winch.stStatus and their members, by name, by handle and by offset. Notifications belong to an AMS
/// address, not to a connection: those of a client that vanished go on at its next connection. Steady traffic
/// (writes by handle, cyclic notifications) allocates nothing.
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
  void set_clock_jump(Nanoseconds jump) noexcept {
    clock_jump_ = jump;
    plc_.set_clock_jump(jump);
  }

  /// Free wire length that the drive holds; see PlcProgram.
  [[nodiscard]] double set_point_m() const noexcept { return plc_.set_point_m(); }
  [[nodiscard]] bool brake_closed() const noexcept { return plc_.brake_closed(); }
  [[nodiscard]] const PlcProgram& plc() const noexcept { return plc_; }
  [[nodiscard]] std::size_t sessions() const noexcept { return sessions_.size(); }
  [[nodiscard]] std::size_t subscriptions() const noexcept { return subscriptions_.size(); }
  /// Frames and requests that were not understood.
  [[nodiscard]] std::uint64_t malformed() const noexcept { return malformed_; }

  /// Injects or removes a fault.
  ///   silent           nothing is sent any more
  ///   late             everything is sent `value` seconds late (default 0.2)
  ///   drop_route       connections are accepted, and closed at their first frame
  ///   stop_plc         the PLC stops; with value 15 it goes to config mode, where its port does not exist
  ///   frozen_cycle     nCycleCount and nTimestamp stand still
  ///   drive_fault      the drive shuts down; `value` is its S-0-0390 number
  ///   close_mid_frame  the next frame is cut in half and its connection closed, once
  ///   half_frames      every frame is sent in two pieces, 1 ms apart
  ///   outlier_100ms    every `value`-th frame (default 50) is 100 ms late, and with it what follows
  /// Refused with the list of names when the name is none of them.
  Status set_fault(std::string_view name, bool active, double value = 0.0);

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
  struct Symbol {
    std::string name;
    std::string_view type;
    DataType data_type{};
    std::uint32_t offset = 0;
    std::uint32_t size = 0;
  };
  struct Handle {
    std::uint32_t id = 0;
    std::uint32_t symbol = 0;
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
    bool silent = false;
    bool drop_route = false;
    bool close_mid_frame = false;
    bool half_frames = false;
    std::optional<Nanoseconds> late;
    std::optional<std::uint64_t> outlier_every;
  };
  /// What lies at an index group and offset: bytes, or an ADS error.
  struct Place {
    std::uint32_t error = ads_error::none;
    Bytes bytes{};
    MutableBytes writable{};
  };

  void add_symbols(std::string_view name, std::string_view type, std::span<const Member> members,
                   std::uint32_t offset, std::uint32_t size);
  [[nodiscard]] Session* find(SessionId id);
  void drop(SessionId id);
  void serve_local(Session& session, const TcpFrame& frame);
  void serve(Session& session, const AmsFrame& frame);
  [[nodiscard]] bool has_route(const NetId& source) const;
  [[nodiscard]] std::uint32_t routing_error(const AmsAddress& target) const;
  void remember(const AmsAddress& client, SessionId session);

  void serve_state(Session& session, const AmsFrame& frame);
  void serve_info(Session& session, const AmsFrame& frame);
  void serve_read(Session& session, const AmsFrame& frame);
  void serve_write(Session& session, const AmsFrame& frame);
  void serve_read_write(Session& session, const AmsFrame& frame);
  void serve_control(Session& session, const AmsFrame& frame);
  void serve_subscribe(Session& session, const AmsFrame& frame);
  void serve_unsubscribe(Session& session, const AmsFrame& frame);
  [[nodiscard]] std::uint32_t read_by_name(const ReadWriteRequest& request, LittleWriter& answer);
  [[nodiscard]] std::uint32_t sum_read(const AmsAddress& server, const ReadWriteRequest& request,
                                       LittleWriter& answer);
  [[nodiscard]] std::uint32_t sum_write(const AmsAddress& server, const ReadWriteRequest& request,
                                        LittleWriter& answer);
  [[nodiscard]] Place place(const AmsAddress& server, std::uint32_t group, std::uint32_t offset);
  [[nodiscard]] std::uint32_t write_value(const AmsAddress& server, std::uint32_t group, std::uint32_t offset,
                                          Bytes data);
  [[nodiscard]] const Symbol* symbol(std::string_view name) const;

  void notify(LabTime t);
  void send_sample(Subscription& subscription, Bytes value);
  void set_state(AdsState state);
  template <class Message>
  void answer(Session& session, const AmsHeader& request, const Message& message,
              std::uint32_t ams_error = 0);
  void transmit(Session& session, Bytes frame);
  void send_or_hold(Session& session, Bytes bytes, Nanoseconds delay);

  DeviceConfig config_;
  ServerOut& out_;
  PlcProgram plc_;
  AdsState state_ = AdsState::run;
  std::uint8_t symbol_version_ = 1;
  std::vector<Symbol> symbols_;
  std::vector<Handle> handles_;
  std::uint32_t next_handle_ = 1;
  std::uint32_t next_subscription_ = 1;
  std::uint16_t next_port_ = 32768;
  std::vector<Session> sessions_;
  std::vector<Client> clients_;
  std::vector<Subscription> subscriptions_;
  Faults faults_{};
  std::uint64_t frames_sent_ = 0;
  std::uint64_t malformed_ = 0;
  LabTime now_{};
  Nanoseconds clock_jump_{0};
  std::array<std::uint8_t, 16> scratch_{};  ///< values that are made when asked for
  ByteBuffer data_;                         ///< data of the answer under construction
  ByteBuffer frame_;                        ///< its frame
};

}  // namespace motionlab::winch

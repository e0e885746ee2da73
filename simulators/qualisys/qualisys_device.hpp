/// @file  The other end of the camera system's wire: a QTM that measures what the simulated world tells it.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/core/endpoint.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/random.hpp"
#include "drivers/core/time.hpp"
#include "drivers/qualisys/qualisys_wire.hpp"
#include "drivers/qualisys/qualisys_wire_command.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_xml.hpp"
#include "simulators/faults/common_faults.hpp"
#include "simulators/qualisys/qualisys_device_faults.hpp"
#include "simulators/qualisys/qualisys_device_frame.hpp"

namespace motionlab::qualisys {

struct DeviceConfig {
  std::vector<BodyDefinition> bodies{{"load", true}};  ///< in the order of XML and data
  std::vector<std::string> labels{};                   ///< of labelled markers, likewise
  double rate_hz = 200.0;    ///< nominal: what `General` says, and the base of `Frequency:n`
  double latency_s = 0.007;  ///< exposure to sending
  double jitter_s = 0.0;     ///< added, uniform in [0, jitter); never reorders
  std::uint64_t seed = 1;    ///< of jitter and garbage
  std::size_t max_clients = 10;
  int newest_version_minor = 28;  ///< 1.8 up to this are spoken; lower it to rehearse an older QTM
  TimecodeSource timecode = TimecodeSource::none;  ///< sent to clients that ask for `Timecode`
  double camera_time_offset_s = 0.0;               ///< camera time minus laboratory time
  std::string qtm_version = "2.17 (build 3700)";
  std::string host = "motionlab";   ///< name in answers to discovery
  std::uint16_t base_port = 22222;  ///< likewise; the little-endian port is the next
  bool measures_at_start = true;    ///< false: QTM waits for somebody to say `New`
  bool control_enabled = true;      ///< clients may become master
  std::string password{};           ///< that a master must know; empty: none
  bool file_is_open = false;        ///< there is a measurement that `Start RTFromFile` can play
  bool waits_for_trigger = false;   ///< `Start` waits for `Trig`
};

/// The server of QTM's real-time protocol for up to ten clients at a time, versions 1.8 to 1.28 (one binary
/// layout; XML as each version has it), little-endian and, if asked, big-endian; and the answer to discovery.
/// Components: 3D, 3DNoLabels, 6D, 6DEuler, each with or without residual, and Timecode. Others may be asked
/// for and stay away, as in a QTM that has no data for them.
///
/// `capture` takes what the cameras saw; `step` sends it when exposure, processing and jitter have passed.
/// Time stamps count the microseconds of exposure time since the measurement began.
///
/// Measurements begin and end by the commands of a master (New, Start, Stop, Close, Trig) or by a fault;
/// every client gets the events. A client that does not take its data loses data, never an answer; one that
/// does not take its answers either is dropped.
class QualisysDevice final : public ServerEvents {
 public:
  QualisysDevice(DeviceConfig config, ServerOut& server, DatagramOut& datagrams);

  void on_accepted(SessionId session, Endpoint from, LabTime t) override;
  void on_bytes(SessionId session, Bytes bytes, LabTime t_received) override;
  void on_closed(SessionId session, LabTime t) override;
  /// Also serves the big-endian port (base + 2). @returns who wants that server's events
  ServerEvents& serve_big_endian(ServerOut& server);
  /// A datagram of the discovery port. Anything but a question is passed over.
  void on_discovery(Bytes datagram, Endpoint from, LabTime t);

  /// Takes what the cameras saw at `t_exposure`. Exposures come in order. Ignored while nothing is measured.
  void capture(const CameraFrame& frame, LabTime t_exposure);
  /// Sends what is due.
  void step(LabTime now);
  /// From now on the server's own clock shows so much more, its time stamps with it; 0: right again.
  void set_clock_jump(Nanoseconds jump) noexcept { clock_jump_ = jump; }

  /// Begins or ends a fault. Faults: refused for a name that is not known (`DeviceFaults::kNames`) or a body
  /// that is not there.
  Status set_fault(std::string_view name, bool active, double value = 0.0);
  /// Every name that `set_fault` knows, its bodies' `occlude:<body>` included, separated by blanks.
  [[nodiscard]] std::string fault_names() const;

  [[nodiscard]] bool measuring() const noexcept;
  [[nodiscard]] std::size_t clients() const noexcept { return sessions_.size(); }
  /// Frames that were captured.
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  /// Datagrams and packets that the transport refused: a client that is gone or does not read.
  [[nodiscard]] std::uint64_t send_failures() const noexcept { return send_failures_; }

 private:
  struct Stream {
    Components components;
    std::optional<Endpoint> udp;  ///< empty: over the connection
    std::uint64_t divisor = 1;    ///< every n-th frame …
    std::optional<double> share;  ///< … or so much of the frames, built by skipping
    double credit = 0.0;
  };
  struct Waiting {
    ByteBuffer packet;
    LabTime t_due;
  };
  /// Which of the two servers, and its session.
  struct SessionKey {
    std::endian order;
    SessionId id;
    auto operator<=>(const SessionKey&) const = default;
  };
  struct Session {
    SessionKey key;
    Endpoint peer;
    PacketSplitter commands;
    int version_minor = 1;  ///< 1.1 until the client asks for another, as in QTM
    std::optional<Stream> stream;
    std::optional<Components> current_frame;  ///< asked for by GetCurrentFrame
    std::deque<Waiting> answers;              ///< not yet taken by the transport, or delayed
  };
  struct Pending {
    DataFrame frame;
    LabTime t_due;
  };
  struct Goodbye {
    SessionKey session;
    std::optional<LabTime> t_close;
  };
  class BigEndianPort final : public ServerEvents {
   public:
    explicit BigEndianPort(QualisysDevice& device) : device_(device) {}
    void on_accepted(SessionId session, Endpoint from, LabTime t) override;
    void on_bytes(SessionId session, Bytes bytes, LabTime t_received) override;
    void on_closed(SessionId session, LabTime t) override;

   private:
    QualisysDevice& device_;
  };

  void accept(SessionKey key, Endpoint from, LabTime t);
  void receive(SessionKey key, Bytes bytes, LabTime t);
  void forget(SessionKey key);
  void close(SessionKey key);

  void on_packet(Session& session, const Packet& packet);
  void on_settings(Session& session, std::string_view xml);
  void on(Session& session, const command::Version& command);
  void on(Session& session, const command::QtmVersion& command);
  void on(Session& session, const command::ByteOrder& command);
  void on(Session& session, const command::GetState& command);
  void on(Session& session, const command::GetParameters& command);
  void on(Session& session, const command::GetCurrentFrame& command);
  void on(Session& session, const command::StreamFrames& command);
  void on(Session& session, const command::StopStream& command);
  void on(Session& session, const command::TakeControl& command);
  void on(Session& session, const command::ReleaseControl& command);
  void on(Session& session, const command::New& command);
  void on(Session& session, const command::Close& command);
  void on(Session& session, const command::Start& command);
  void on(Session& session, const command::Stop& command);
  void on(Session& session, const command::Trigger& command);
  void on(Session& session, const command::SetEvent& command);
  /// Whether the client may control; tells it when not.
  [[nodiscard]] bool is_master(Session& session);
  /// Whether the client's version is served; tells it when not.
  [[nodiscard]] bool has_version(Session& session);

  void reply(Session& session, std::string_view text);
  void refuse(Session& session, std::string_view text);
  void answer(Session& session, ByteBuffer packet);
  void tell_all(Event event);
  void flush(Session& session);
  [[nodiscard]] bool send(const Session& session, Bytes packet);
  void send_data(Session& session, Bytes packet);
  void send_datagram(Endpoint to, MutableBytes packet);
  void deliver(const DataFrame& frame);
  void deliver(Session& session, const DataFrame& frame, const Components& components,
               std::optional<Endpoint> udp);
  [[nodiscard]] static bool takes(Stream& stream, std::uint64_t frame_index);
  [[nodiscard]] ByteBuffer disturbed(Bytes packet);

  void restart_time();
  void begin(Event event);
  void end(Event event);
  void boot();
  void say_goodbye();
  void close_mid_frame();
  void set_body_list(std::vector<BodyDefinition> list, bool announced);
  void begin_fault(std::string_view name, double value);
  void end_fault(std::string_view name, double value);

  DeviceConfig config_;
  ServerOut& server_;
  ServerOut* big_endian_server_ = nullptr;
  BigEndianPort big_endian_port_{*this};
  DatagramOut& datagrams_;
  Random jitter_;
  Random garbage_;
  faults::CommonFaults common_;
  DeviceFaults faults_;
  std::vector<BodyDefinition> list_;
  std::map<SessionKey, Session> sessions_;
  std::vector<Goodbye> goodbyes_;  ///< closed a little later, so that the last bytes arrive
  std::optional<SessionKey> master_;
  LabTime now_{};
  Event state_ = Event::capture_started;
  Nanoseconds clock_jump_{0};
  std::optional<LabTime> t_start_;  ///< exposure of the measurement's first frame
  std::uint64_t exposures_ = 0;
  std::uint32_t frame_number_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t delivered_ = 0;
  std::uint64_t send_failures_ = 0;
  CameraFrame seen_;  ///< the last exposure, as `stuck` repeats it
  std::deque<Pending> pending_;
  LabTime t_last_due_{};
  std::array<std::uint8_t, kDatagramLimit> packet_{};
};

}  // namespace motionlab::qualisys

/// @file  The other end of the camera system's wire: a QTM that measures what the simulated world tells it.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/endpoint.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/random.hpp"
#include "drivers/core/time.hpp"
#include "drivers/qualisys/qualisys_wire.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_xml.hpp"

namespace motionlab::qualisys {

struct DeviceConfig {
  std::vector<BodyDefinition> bodies{{"load", true}};  ///< in the order of XML and data
  double rate_hz = 200.0;    ///< nominal: what `General` says, and the base of `Frequency:n`
  double latency_s = 0.007;  ///< exposure to sending
  double jitter_s = 0.0;     ///< added, uniform in [0, jitter); never reorders
  std::uint64_t seed = 1;    ///< of jitter and loss
  std::size_t max_clients = 10;
  int newest_version_minor = 28;      ///< 1.8 up to this are spoken; lower it to rehearse an older QTM
  bool camera_time = false;           ///< send the camera time to clients that ask for `Timecode`
  double camera_time_offset_s = 0.0;  ///< camera time minus laboratory time
  std::string qtm_version = "2.17 (build 3700)";
};

/// One body of a physical measurement, in the camera system's global frame.
struct MeasuredBody {
  std::string name;
  bool tracked = false;
  std::array<double, 3> p_camera_body_m{};
  std::array<double, 4> q_camera_body{1.0, 0.0, 0.0, 0.0};  ///< unit quaternion w, x, y, z
  double residual_m = 0.0;
};

/// What the cameras saw in one exposure. Bodies of the device's list that are not here are lost.
struct CameraFrame {
  std::vector<MeasuredBody> bodies;
  double drop_rate = 0.0;         ///< 0…1
  double out_of_sync_rate = 0.0;  ///< 0…1
};

/// The server of QTM's real-time protocol for several clients: little-endian, versions 1.8 to 1.28 (one
/// binary layout), components 6D, 6DRes and Timecode. Other components may be asked for and stay away, as in
/// a QTM that has no data for them.
///
/// Measures from birth. `capture` takes what the cameras saw; `step` sends it when exposure, processing and
/// jitter have passed. Time stamps count the microseconds of exposure time since the measurement began.
///
/// Commands: Version, QTMVersion, ByteOrder, GetState, GetParameters (All, General, 6D; the other groups are
/// left out), GetCurrentFrame, StreamFrames (with or without UDP, Stop), TakeControl, ReleaseControl; others
/// are answered by `Parse error`. Measurements are started and stopped by the fault `stop_measurement`, not
/// by clients.
class QualisysDevice final : public ServerEvents {
 public:
  /// What `set_fault` knows:
  ///  silent              nothing is sent any more, connections stay open
  ///  occlude             no body is tracked
  ///  occlude:<body>      this body is not tracked
  ///  loss                frames are lost; value: probability (0: all of them)
  ///  late                frames are late; value: s beyond the latency (0: 0.1 s)
  ///  stop_measurement    the measurement is stopped; a new one begins when the fault ends
  ///  restart_timestamp   once: time stamps and frame numbers begin again, unannounced
  ///  stuck_frame_number  the frame number is always 1
  ///  close_mid_frame     once: every connection ends in the middle of a packet
  ///  foreign             each datagram is followed by one of another protocol
  ///  truncate            each datagram lacks its last byte
  ///  oversize            each datagram has one byte too many
  ///  body_list_change    a body is added before the others; value 0: announced by an event, else silently
  static constexpr std::string_view kFaults =
      "unknown fault; known are silent, occlude, occlude:<body>, loss, late, stop_measurement, "
      "restart_timestamp, "
      "stuck_frame_number, close_mid_frame, foreign, truncate, oversize, body_list_change";

  QualisysDevice(DeviceConfig config, ServerOut& server, DatagramOut& datagrams);

  void on_accepted(SessionId session, Endpoint from, LabTime t) override;
  void on_bytes(SessionId session, Bytes bytes, LabTime t_received) override;
  void on_closed(SessionId session, LabTime t) override;

  /// Takes what the cameras saw at `t_exposure`. Exposures come in order. Ignored while nothing is measured.
  void capture(const CameraFrame& frame, LabTime t_exposure);
  /// Sends what is due.
  void step(LabTime now);
  /// From now on the server's own clock shows so much more, its time stamps with it; 0: right again.
  void set_clock_jump(Nanoseconds jump) noexcept { clock_jump_ = jump; }

  /// Begins or ends a fault. Faults: refused for a name that is not known (`kFaults`) or a body that is not
  /// there.
  Status set_fault(std::string_view name, bool active, double value = 0.0);

  [[nodiscard]] bool measuring() const noexcept { return state_ == Event::capture_started; }
  [[nodiscard]] std::size_t clients() const noexcept { return sessions_.size(); }
  /// Frames that were captured and not lost.
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  /// Datagrams and packets that the transport refused: a client that is gone or does not read.
  [[nodiscard]] std::uint64_t send_failures() const noexcept { return send_failures_; }

 private:
  struct Stream {
    Components components;
    std::optional<Endpoint> udp;  ///< empty: over the connection
    std::uint64_t divisor = 0;    ///< every n-th frame; 0: by `share`
    double share = 1.0;           ///< of the frames, built by skipping
    double credit = 0.0;
  };
  struct Session {
    Endpoint peer;
    PacketSplitter commands{kCommandLimit};
    int version_minor = 1;  ///< 1.1 until the client asks for another, as in QTM
    std::optional<Stream> stream;
    std::optional<Components> current_frame;  ///< asked for by GetCurrentFrame
  };
  struct Pending {
    DataFrame frame;
    LabTime t_due;
  };
  struct Goodbye {
    SessionId session;
    std::optional<LabTime> t_close;
  };
  using Words = std::vector<std::string_view>;

  static constexpr std::size_t kCommandLimit = 65536;

  void on_command(SessionId id, Session& session, std::string_view text);
  void version(SessionId id, Session& session, const Words& words);
  void parameters(SessionId id, const Session& session, const Words& words);
  void stream_frames(SessionId id, Session& session, const Words& words);
  void current_frame(SessionId id, Session& session, const Words& words);
  void take_control(SessionId id);
  void release_control(SessionId id);

  void reply(SessionId id, std::string_view text);
  void refuse(SessionId id, std::string_view text);
  void send(SessionId id, Bytes packet);
  void send_all(Bytes packet);
  void send_datagram(Endpoint to, Bytes packet);
  void deliver(const DataFrame& frame);
  [[nodiscard]] static bool takes(Stream& stream, std::uint64_t frame_index);
  [[nodiscard]] bool occluded(const std::string& body) const;

  void restart_time();
  void start_measurement();
  void stop_measurement();
  void close_mid_frame();
  void set_body_list(bool changed, bool announced);
  /// The value of an active fault.
  [[nodiscard]] std::optional<double> fault(std::string_view name) const;

  DeviceConfig config_;
  ServerOut& server_;
  DatagramOut& datagrams_;
  Random jitter_;
  Random loss_;
  std::vector<BodyDefinition> list_;
  std::map<SessionId, Session> sessions_;
  std::vector<Goodbye> goodbyes_;  ///< closed a little later, so that the last bytes arrive
  std::optional<SessionId> master_;
  Event state_ = Event::capture_started;
  Nanoseconds clock_jump_{0};
  std::optional<LabTime> t_start_;  ///< exposure of the measurement's first frame
  std::uint32_t frame_number_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t delivered_ = 0;
  std::uint64_t send_failures_ = 0;
  std::deque<Pending> pending_;
  LabTime t_last_due_{};
  std::map<std::string, double, std::less<>> faults_;
  std::set<std::string, std::less<>> occluded_;  ///< in lower case
  std::array<std::uint8_t, 8192> packet_{};
};

}  // namespace motionlab::qualisys

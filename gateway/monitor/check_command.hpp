/// @file  `motionlab check mru`: listens to a unit's port instead of the gateway and says what comes there.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/core/bytes.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/time.hpp"
#include "drivers/mru/mru_wire_detect.hpp"
#include "drivers/mru/mru_wire_formats.hpp"
#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct CheckMruCommand {
  std::uint16_t port = 0;                ///< UDP, on all addresses of this host
  double seconds = 2;                    ///< how long to listen
  std::vector<std::uint16_t> variables;  ///< of MRUBIN or NMEAP, by number; empty: the laboratory's 24
  bool json = false;
};

/// What is learnt of a stream. Knows no socket.
class MruStream {
 public:
  explicit MruStream(const mru::VariableList& variables) : variables_(variables) {}

  void take(Bytes datagram, Endpoint from, LabTime t_received);

  [[nodiscard]] const mru::FormatDetector& detector() const noexcept { return detector_; }
  [[nodiscard]] std::optional<mru::Motion> newest() const noexcept { return newest_; }
  /// Why the newest datagram of the known format could not be decoded; nothing when it could.
  [[nodiscard]] std::optional<Fault> fault() const noexcept { return fault_; }
  /// Datagrams per second; 0 before the second one.
  [[nodiscard]] double rate_hz() const noexcept;
  /// Of MRUBIN: in how many of the decoded datagrams each rule matched; of the others `good` alone counts.
  struct Checksums {
    std::uint64_t decoded = 0, good = 0, sum8 = 0, ones_complement = 0;
  };
  [[nodiscard]] const Checksums& checksums() const noexcept { return checksums_; }
  [[nodiscard]] std::optional<Endpoint> from() const noexcept { return from_; }

 private:
  void decode(Bytes datagram);

  mru::VariableList variables_;
  mru::FormatDetector detector_;
  std::optional<mru::Decoder> decoder_;
  std::optional<mru::Motion> newest_;
  std::optional<Fault> fault_;
  Checksums checksums_;
  std::optional<Endpoint> from_;
  std::optional<LabTime> t_first_;
  LabTime t_last_{};
};

/// Listens at the command's port for its time, or until the user has had enough.
/// @throws StartupError  the port is in use, or the variables make no list
[[nodiscard]] MruStream listen_to_mru(const CheckMruCommand& command, const std::atomic<bool>& interrupted);

/// Listens and tells the format, the rate, how the checksums came out, and one decoded sample.
///
/// The port must be free: the gateway must not be listening there. Nothing is ever sent.
/// @returns kExitGood when the format is known and a sample was decoded; kExitWrong when something came but
///          is of no known or of no decodable format; kExitNobody when nothing came
/// @throws StartupError  the port is in use, or the variables make no list
int run_check_mru(const CheckMruCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor

// What QTM answers to commands. Source of the texts: QTM RT Protocol documentation, "Commands".
#include "drivers/qualisys/qualisys_wire_text.hpp"
#include "simulators/qualisys/qualisys_device.hpp"

namespace motionlab::qualisys {

namespace {

constexpr int kOldestVersionMinor = 8;  // before it, the data had doubles and padding
constexpr std::string_view kVersionNotSupported = "Version NOT supported";
constexpr std::size_t kEventLabelMax = 98;

}  // namespace

void QualisysDevice::on_packet(Session& session, const Packet& packet) {
  if (packet.type == PacketType::xml) return on_settings(session, packet_text(packet.payload));
  const auto command = packet.type == PacketType::command
                           ? parse_command(packet_text(packet.payload))
                           : Result<Command>{Fault{Reason::refused, "Parse error"}};
  if (!command) return refuse(session, command.fault().text);
  std::visit([&](const auto& c) { on(session, c); }, *command);
}

bool QualisysDevice::is_master(Session& session) {
  if (master_ == session.key) return true;
  refuse(session, "You must be master to issue this command");
  return false;
}

/// A client that asked for no version has 1.1, whose layout is not served here.
bool QualisysDevice::has_version(Session& session) {
  if (session.version_minor >= kOldestVersionMinor) return true;
  refuse(session, kVersionNotSupported);
  return false;
}

// Questions
// ----------------------------------------------------------------------------------------------------

void QualisysDevice::on(Session& session, const command::Version& version) {
  if (!version.minor) return reply(session, "Version is 1." + std::to_string(session.version_minor));
  const int newest = static_cast<int>(faults_.value("old_version").value_or(config_.newest_version_minor));
  if (*version.minor < kOldestVersionMinor || *version.minor > newest)
    return refuse(session, kVersionNotSupported);
  session.version_minor = *version.minor;
  reply(session, "Version set to 1." + std::to_string(*version.minor));
}

void QualisysDevice::on(Session& session, const command::QtmVersion&) {
  reply(session, "QTM Version is " + config_.qtm_version);
}

void QualisysDevice::on(Session& session, const command::ByteOrder&) {
  const bool little = session.key.order == std::endian::little;
  reply(session, little ? "Byte order is little endian" : "Byte order is big endian");
}

void QualisysDevice::on(Session& session, const command::GetState&) {
  if (!faults_.is_on("no_state")) answer(session, encode_event(state_, session.key.order));
}

void QualisysDevice::on(Session& session, const command::GetParameters& asked) {
  if (!has_version(session)) return;
  const XmlContent content{.version_minor = session.version_minor,
                           .rate_hz = config_.rate_hz,
                           .general = asked.groups.general,
                           .bodies = asked.groups.bodies,
                           .markers = asked.groups.markers,
                           .body_list = list_,
                           .labels = config_.labels};
  answer(session, encode_text(PacketType::xml, write_parameters_xml(content), session.key.order));
}

// Frames
// -------------------------------------------------------------------------------------------------------

void QualisysDevice::on(Session& session, const command::GetCurrentFrame& asked) {
  if (!has_version(session)) return;
  if (!measuring()) return answer(session, encode_no_more_data(session.key.order));
  session.current_frame = asked.components;
}

/// No text answers this command: clients pair answers with commands by order.
void QualisysDevice::on(Session& session, const command::StreamFrames& asked) {
  if (!has_version(session)) return;
  Stream stream;
  stream.components = asked.components;
  stream.divisor = asked.divisor;
  if (asked.rate_hz) stream.share = std::min(*asked.rate_hz / config_.rate_hz, 1.0);
  if (asked.udp)
    stream.udp =
        Endpoint{asked.udp->address != 0 ? asked.udp->address : session.peer.address, asked.udp->port};
  session.stream = stream;
  if (!measuring()) answer(session, encode_no_more_data(session.key.order));
}

void QualisysDevice::on(Session& session, const command::StopStream&) {
  session.stream.reset();
}

// Control
// ------------------------------------------------------------------------------------------------------

void QualisysDevice::on(Session& session, const command::TakeControl& command) {
  if (!config_.control_enabled) return refuse(session, "Client control disabled in QTM");
  if (master_ == session.key) return reply(session, "You are already master");
  if (master_) {
    const Endpoint peer = sessions_.at(*master_).peer;
    return refuse(session,
                  address_to_string(peer.address) + " (" + std::to_string(peer.port) + ") is already master");
  }
  if (!config_.password.empty() && command.password != config_.password)
    return refuse(session, "Wrong or missing password");
  master_ = session.key;
  reply(session, "You are now master");
}

void QualisysDevice::on(Session& session, const command::ReleaseControl&) {
  if (master_ != session.key) return reply(session, "You are already a regular client");
  master_.reset();
  reply(session, "You are now a regular client");
}

void QualisysDevice::on(Session& session, const command::New&) {
  if (!is_master(session)) return;
  if (state_ == Event::capture_stopped)
    return refuse(session, "The previous measurement has not been saved or closed");
  if (state_ != Event::connection_closed) return reply(session, "Already connected");
  reply(session, "Creating new connection");
  begin(Event::connected);
}

void QualisysDevice::on(Session& session, const command::Close&) {
  if (!is_master(session)) return;
  if (state_ == Event::connection_closed) return reply(session, "No connection to close");
  reply(session, state_ == Event::rt_from_file_started ? "Closing file" : "Closing connection");
  end(Event::connection_closed);
}

void QualisysDevice::on(Session& session, const command::Start& command) {
  if (!is_master(session)) return;
  if (command.from_file) {
    if (!config_.file_is_open) return refuse(session, "No file open");
    if (state_ == Event::rt_from_file_started) return refuse(session, "RT from file already running");
    reply(session, "Starting RT from file");
    return begin(Event::rt_from_file_started);
  }
  if (state_ == Event::capture_started || state_ == Event::waiting_for_trigger)
    return refuse(session, "Measurement is already running");
  if (state_ != Event::connected) return refuse(session, "Not connected. Create connection with new");
  reply(session, "Starting measurement");
  begin(config_.waits_for_trigger ? Event::waiting_for_trigger : Event::capture_started);
}

void QualisysDevice::on(Session& session, const command::Stop&) {
  if (!is_master(session)) return;
  const bool file = state_ == Event::rt_from_file_started;
  if (!file && state_ != Event::capture_started && state_ != Event::waiting_for_trigger)
    return refuse(session, "No measurement is running");
  reply(session, "Stopping measurement");
  end(file ? Event::rt_from_file_stopped : Event::capture_stopped);
}

void QualisysDevice::on(Session& session, const command::Trigger&) {
  if (!is_master(session)) return;
  if (state_ != Event::waiting_for_trigger) return refuse(session, "QTM not waiting for trig");
  reply(session, "Trig ok");
  tell_all(Event::trigger);
  begin(Event::capture_started);
}

void QualisysDevice::on(Session& session, const command::SetEvent& command) {
  if (!is_master(session)) return;
  if (state_ != Event::capture_started) return refuse(session, "QTM is not capturing");
  if (command.label.size() > kEventLabelMax) return refuse(session, "Event label too long");
  reply(session, "Event set");
}

/// Settings that a master sends. The list of bodies is taken over; the rest has nothing here that it sets.
void QualisysDevice::on_settings(Session& session, std::string_view xml) {
  if (!is_master(session)) return;
  auto settings = parse_settings_xml(xml);
  if (!settings) return refuse(session, "Setting parameters failed");
  reply(session, "Setting parameters succeeded");
  if (auto bodies = std::move(settings).value()) set_body_list(*std::move(bodies), true);
}

}  // namespace motionlab::qualisys

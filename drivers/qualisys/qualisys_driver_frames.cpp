// From data packets to samples.
#include <algorithm>
#include <utility>

#include "drivers/qualisys/qualisys_driver.hpp"
#include "drivers/qualisys/qualisys_driver_faults.hpp"

namespace motionlab::qualisys {

namespace {

/// A wrong number of bodies makes us read the list again, but not at the pace of the frames.
constexpr Nanoseconds kListPause = 1s;

}  // namespace

void QualisysDriver::on_datagram(Bytes datagram, Endpoint from, LabTime t_received) {
  if (config_.server_address != 0 && from.address != config_.server_address)
    return health_.rejected(
        {Reason::foreign, "datagram on the stream's port from another address than QTM's"});
  const auto packet = decode_datagram(datagram, config_.byte_order);
  if (!packet) return health_.rejected(packet.fault());
  if (packet->type == PacketType::data) return on_frame(packet->payload, t_received);
  if (packet->type == PacketType::no_more_data) return on_no_more_data(t_received);
  health_.rejected({Reason::bad_header, "datagram on the stream's port is not a data packet"});
}

void QualisysDriver::on_frame(Bytes payload, LabTime t_received) {
  if (state_ != State::streaming)
    return health_.rejected({Reason::unexpected, "frame while none was expected: ignored"});
  const auto packet = decode_data(payload, config_.byte_order);
  if (!packet) return health_.rejected(packet.fault());
  if (packet->has_angles()) return on_checked_frame(payload);  // asked for by the check, over the connection
  if (!packet->has_bodies() && !packet->has_unlabelled() && !packet->timecode)
    return health_.rejected({Reason::unexpected, "frame without anything that was asked for"});

  const FrameOrder::Verdict verdict = order_.judge(*packet);
  if (verdict.fault) return health_.rejected(*verdict.fault);
  if (verdict.first_part) begin_frame(*packet, verdict, t_received);
  if (packet->has_bodies() && packet->bodies.size != list_.size()) return on_wrong_count(t_received);
  if (packet->has_bodies() || packet->has_unlabelled()) stamp(*packet, t_received);
  if (packet->has_bodies()) tell_bodies(*packet, t_received);
  if (packet->has_unlabelled()) tell_hook(*packet, t_received);
}

/// The answer to the orientation check: a frame with both forms, that is told to nobody.
void QualisysDriver::on_checked_frame(Bytes payload) {
  const auto frame = decode_data(payload, config_.byte_order);
  if (!frame) return health_.rejected(frame.fault());
  if (!frame->has_angles() || !frame->has_bodies() || state_ != State::streaming)
    return health_.rejected({Reason::unexpected, "frame over the connection that was not asked for"});
  if (orientation_.judge(*frame)) advise();
}

void QualisysDriver::on_wrong_count(LabTime now) {
  health_.rejected(kWrongCount);
  wrong_count_ = true;
  lose_all(now);
  advise();
  if (now - t_list_ >= kListPause) read_bodies(false, now);
}

void QualisysDriver::begin_frame(const DataFrame& packet, const FrameOrder::Verdict& verdict,
                                 LabTime t_received) {
  if (verdict.restarted) clock_.reset();
  // A frame is over when the next begins: if it brought no markers, the hook is not seen any more.
  if (!std::exchange(hook_in_frame_, false) && std::exchange(hook_showing_, false))
    tell(hook_, BodyPose{}, t_measured_, t_received);
  health_.lost(verdict.lost);
  head_ = {packet.frame_number, packet.drop_rate, packet.out_of_sync_rate};
  stamped_ = false;
}

/// Maps the frame's exposure to laboratory time, once a frame. The camera time counts when it comes together
/// with what it stamps; of a frame in parts it may come too late.
void QualisysDriver::stamp(const DataFrame& packet, LabTime t_received) {
  t_frame_ = t_received;
  showing_ = true;
  if (std::exchange(stamped_, true)) return;
  const CameraTime* camera = packet.camera_time();
  if (std::exchange(has_camera_time_, camera != nullptr) != (camera != nullptr)) clock_.reset();
  const Nanoseconds t_device =
      camera ? camera->since_epoch : Nanoseconds{static_cast<std::int64_t>(packet.timestamp_us) * 1000};
  t_measured_ = clock_.map(t_device, t_received);
  health_.accepted(t_measured_, t_received);
}

void QualisysDriver::tell_bodies(const DataFrame& packet, LabTime t_received) {
  head_.drop_rate = packet.drop_rate;
  head_.out_of_sync_rate = packet.out_of_sync_rate;
  if (silent_ || wrong_count_) {
    silent_ = wrong_count_ = false;
    advise();
  }
  for (Wanted& body : wanted_)
    tell(body, body.index ? packet.bodies.all[*body.index] : BodyPose{}, t_measured_, t_received);
}

void QualisysDriver::tell_hook(const DataFrame& packet, LabTime t_received) {
  if (hook_.name.empty()) return;
  const bool was_ambiguous = pair_.ambiguous();
  hook_in_frame_ = hook_showing_ = true;
  tell(hook_, pair_.find(packet.unlabelled.view()), t_measured_, t_received);
  if (pair_.ambiguous() != was_ambiguous) advise();
}

void QualisysDriver::tell(Wanted& body, const BodyPose& pose, LabTime t_measured, LabTime t_received) {
  topic::Bodies sample;
  sample.device = config_.device;
  sample.body = body.name;
  sample.sequence_number = ++body.sequence_number;
  sample.t_measured_ns = to_ns(t_measured);
  sample.t_received_ns = to_ns(t_received);
  sample.frame_number = head_.frame_number;
  sample.tracked = pose.tracked;
  sample.p_camera_body_m = pose.p_camera_body_m;
  sample.q_camera_body = pose.q_camera_body;
  sample.residual_m = pose.residual_m;
  sample.drop_rate = head_.drop_rate;
  sample.out_of_sync_rate = head_.out_of_sync_rate;
  sink_(sample);
}

/// Says once of every body that it is not seen any more. Stamped with the first exposure that is missing, so
/// that stamps never go back, even when a stalled network still holds frames.
void QualisysDriver::lose_all(LabTime now) {
  pair_.reset();
  if (!std::exchange(showing_, false)) return;
  const LabTime t_measured = std::min(t_measured_ + from_seconds(config_.frame_period_s), now);
  for (Wanted& body : wanted_) tell(body, BodyPose{}, t_measured, now);
  if (std::exchange(hook_showing_, false)) tell(hook_, BodyPose{}, t_measured, now);
}

void QualisysDriver::forget_time() noexcept {
  clock_.reset();
  order_.reset();
  stamped_ = false;
}

}  // namespace motionlab::qualisys

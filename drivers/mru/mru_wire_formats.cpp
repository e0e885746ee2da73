#include "drivers/mru/mru_wire_formats.hpp"

#include <tuple>

#include "drivers/mru/mru_wire_bin23.hpp"
#include "drivers/mru/mru_wire_em3000.hpp"
#include "drivers/mru/mru_wire_km.hpp"
#include "drivers/mru/mru_wire_nmeap.hpp"
#include "drivers/mru/mru_wire_tss1.hpp"

namespace motionlab::mru {
namespace {

/// Which value of a motion each variable of MRUBIN is: one table for both directions.
template <class M, class Visit>
void for_each_variable(M& motion, Visit&& visit) {
  using enum Variable;
  const auto triple = [&](Variable a, Variable b, Variable c, auto& values) {
    visit(a, values[0]);
    visit(b, values[1]);
    visit(c, values[2]);
  };
  triple(roll, pitch, yaw, motion.euler_heading_mru_rad);
  triple(ang_rate_r, ang_rate_p, ang_rate_y, motion.omega_mru_radps);
  visit(ang_rate_d, motion.omega_down_radps);
  triple(vel_mru_r, vel_mru_p, vel_mru_y, motion.v_mru_mps);
  triple(acc_mru_r, acc_mru_p, acc_mru_y, motion.a_mru_mps2);
  triple(pos_cg_f, pos_cg_s, pos_cg_d, motion.p_heading_origin_m);
  triple(vel_cg_f, vel_cg_s, vel_cg_d, motion.v_heading_origin_mps);
  triple(acc_cg_f, acc_cg_s, acc_cg_d, motion.a_heading_origin_mps2);
  visit(sensor_temperature, motion.sensor_temperature_degc);
}

Result<Telegram> decode_mrubin(Bytes datagram, const Layout& layout) noexcept {
  const Result<Frame> frame = decode(datagram, layout);
  if (!frame) return frame.fault();
  return Telegram{motion_of(*frame, layout), {Check::Rule::unsettled, true, frame->checksum_match}};
}

Result<Telegram> decode_nmeap(Bytes datagram, const Layout& layout) noexcept {
  const Result<nmeap::Sentence> sentence = nmeap::decode(as_text(datagram), layout);
  if (!sentence) return sentence.fault();
  const bool good = sentence->checksum == sentence::Checksum::good;
  return Telegram{motion_of(sentence->frame, layout), {Check::Rule::known, good, {}}};
}

Result<Telegram> decode_em3000(Bytes datagram, Format format) noexcept {
  const Result<em3000::Frame> frame = em3000::decode(datagram);
  if (!frame) return frame.fault();
  if ((frame->status == em3000::kEm1000) != (format == Format::em1000)) {
    return Fault{Reason::bad_header,
                 "EM1000 on a port for EM3000, or the other way round: see the format setting"};
  }
  const Result<Motion> motion = em3000::motion_of(*frame);
  if (!motion) return motion.fault();
  return Telegram{*motion, {}};
}

Result<Telegram> decode_bin23(Bytes datagram) noexcept {
  const Result<bin23::Frame> frame = bin23::decode(datagram);
  if (!frame) return frame.fault();
  return Telegram{bin23::motion_of(*frame), {Check::Rule::known, frame->crc_good, {}}};
}

template <class F>
Result<Telegram> as_telegram(const Result<F>& frame) noexcept {
  if (!frame) return frame.fault();
  return Telegram{motion_of(*frame), {}};
}

/// The values of a motion in the order of the list.
Frame frame_of(const Motion& motion, const Layout& layout, Nanoseconds t_unit) noexcept {
  Frame frame;
  frame.stable = motion.stable;
  frame.size = layout.variables.size();
  const auto set = [&](Variable variable, double value) {
    if (const auto index = layout.variables.index_of(variable)) frame.values[*index] = value;
  };
  set(Variable::system_time, static_cast<double>(UnitTime::of(t_unit).ms));
  for_each_variable(motion, set);
  return frame;
}

Result<Bytes> encode_psxn(const Motion& motion, MutableBytes to) noexcept {
  using nmea::Kind;
  const auto& [roll, pitch, yaw] = motion.euler_heading_mru_rad;
  const auto& omega = motion.omega_mru_radps;
  const double quality = !motion.stable ? 2.0 : motion.reduced ? 1.0 : 0.0;
  const std::array sentences{
      nmea::Sentence{Kind::quality, {}, {0.0, 0.0, 0.0, quality}},
      nmea::Sentence{
          Kind::rates,
          {},
          {omega[0] / kDegree, omega[1] / kDegree, omega[2] / kDegree, motion.v_heading_origin_mps[2]}},
      nmea::Sentence{Kind::attitude,
                     {},
                     {roll / kDegree, pitch / kDegree, heading_of_yaw(yaw), motion.p_heading_origin_m[2]}}};
  std::size_t size = 0;
  for (const nmea::Sentence& sentence : sentences) {
    const Result<Bytes> bytes = nmea::encode(sentence, to.subspan(size));
    if (!bytes) return bytes.fault();
    size += bytes->size();
  }
  return Bytes{to.first(size)};
}

Result<Bytes> encode_prdid(const Motion& motion, MutableBytes to) noexcept {
  const auto& [roll, pitch, yaw] = motion.euler_heading_mru_rad;
  return nmea::encode(
      {nmea::Kind::prdid, {}, {pitch / kDegree, roll / kDegree, heading_of_yaw(yaw), kNotTold}}, to);
}

}  // namespace

Decoder::Decoder(Format format, const Layout& layout) noexcept
    : format_(format),
      layout_(layout),
      listener_(format == Format::prdid ? nmea::Kind::prdid : nmea::Kind::attitude) {}

Result<std::optional<Telegram>> Decoder::decode(Bytes datagram) noexcept {
  const auto checked = [&](const Result<Telegram>& telegram) -> Result<std::optional<Telegram>> {
    if (!telegram) return telegram.fault();
    const Status plausible = check_plausible(telegram->motion, layout_.limits);
    if (!plausible) return plausible.fault();
    return std::optional{*telegram};
  };
  switch (format_) {
    case Format::mrubin:
    case Format::nmeap: {
      // Their decoders know each variable's own limit; a list may lack the attitude.
      const Result<Telegram> telegram =
          format_ == Format::mrubin ? decode_mrubin(datagram, layout_) : decode_nmeap(datagram, layout_);
      if (!telegram) return telegram.fault();
      return std::optional{*telegram};
    }
    case Format::km_binary:
      return checked(as_telegram(km::decode(datagram)));
    case Format::em3000:
    case Format::em1000:
      return checked(decode_em3000(datagram, format_));
    case Format::tss1:
      return checked(as_telegram(tss1::decode(datagram)));
    case Format::bin23:
      return checked(decode_bin23(datagram));
    case Format::psxn:
    case Format::prdid:
      break;
  }
  const Result<std::optional<Telegram>> heard = listener_.take(datagram);
  if (!heard || !*heard) return heard;
  return checked(**heard);
}

Motion motion_of(const Frame& frame, const Layout& layout) noexcept {
  Motion motion;
  motion.stable = frame.stable;
  if (const auto ms = frame.system_time_ms(layout)) motion.t_unit = UnitTime{*ms, {}};
  for_each_variable(motion, [&](Variable variable, double& value) {
    value = frame.value(variable, layout).value_or(kNotTold);
  });
  return motion;
}

Result<Bytes> encode(const Motion& motion, Format format, const Layout& layout, ChecksumRule rule,
                     Nanoseconds t_unit, MutableBytes to) noexcept {
  switch (format) {
    case Format::mrubin:
      return encode(frame_of(motion, layout, t_unit), layout, rule, to);
    case Format::nmeap:
      return nmeap::encode(frame_of(motion, layout, t_unit), layout, to);
    case Format::km_binary:
      return km::encode(km::frame_of(motion, t_unit), to);
    case Format::em3000:
    case Format::em1000:
      return em3000::encode(em3000::frame_of(motion, format), to);
    case Format::tss1:
      return tss1::encode(tss1::frame_of(motion), to);
    case Format::psxn:
      return encode_psxn(motion, to);
    case Format::prdid:
      return encode_prdid(motion, to);
    case Format::bin23:
      break;
  }
  return bin23::encode(bin23::frame_of(motion, t_unit), to);
}

}  // namespace motionlab::mru

#include "drivers/mru/mru_wire_detect.hpp"

#include "drivers/mru/mru_wire_bin23.hpp"
#include "drivers/mru/mru_wire_em3000.hpp"
#include "drivers/mru/mru_wire_km.hpp"
#include "drivers/mru/mru_wire_nmea.hpp"
#include "drivers/mru/mru_wire_nmeap.hpp"
#include "drivers/mru/mru_wire_tss1.hpp"

namespace motionlab::mru {
namespace {

bool is_mrubin(Bytes datagram) noexcept {
  return datagram.size() > kOverhead && (datagram[0] == kStableHeader || datagram[0] == kUnstableHeader) &&
         datagram.size() == std::size_t{datagram[1]} + 3 && datagram[1] % 4 == 1;
}

bool is_bin23(Bytes datagram) noexcept {
  const auto frame = bin23::decode(datagram);
  return frame && frame->crc_good;
}

bool is_sentence(Bytes datagram, nmea::Kind attitude) noexcept {
  return nmea::Listener{attitude}.take(datagram).ok();
}

/// Token and number of variables, where the user of the unit chooses them.
struct UsersChoice {
  std::uint8_t token = 0;
  std::size_t variables = 0;
};

std::optional<UsersChoice> choice_in_nmeap(Bytes datagram) noexcept {
  const auto opened = sentence::open(as_text(datagram), nmeap::kMaxSentence);
  if (!opened || opened->checksum != sentence::Checksum::good) return std::nullopt;
  std::string_view rest = opened->body;
  if (!rest.starts_with(nmeap::kSettled) && !rest.starts_with(nmeap::kUnsettled)) return std::nullopt;
  rest.remove_prefix(nmeap::kSettled.size());
  const auto token = sentence::number(sentence::take_field(rest));
  if (!token || !(*token >= 0 && *token <= 255)) return std::nullopt;
  return UsersChoice{static_cast<std::uint8_t>(*token), sentence::field_count(rest)};
}

std::optional<UsersChoice> choice_in(Bytes datagram, Format format) noexcept {
  if (format == Format::mrubin) return UsersChoice{datagram[2], (datagram.size() - kOverhead) / 4};
  return format == Format::nmeap ? choice_in_nmeap(datagram) : std::nullopt;
}

std::optional<Format> em_format(Bytes datagram) noexcept {
  const auto frame = em3000::decode(datagram);
  if (!frame || !em3000::motion_of(*frame)) return std::nullopt;
  return frame->status == em3000::kEm1000 ? Format::em1000 : Format::em3000;
}

}  // namespace

std::optional<Format> looks_like(Bytes datagram) noexcept {
  if (km::decode(datagram).ok()) return Format::km_binary;
  if (is_bin23(datagram)) return Format::bin23;
  if (is_mrubin(datagram)) return Format::mrubin;
  if (as_text(datagram).starts_with("$PRDID,")) {
    return is_sentence(datagram, nmea::Kind::prdid) ? std::optional{Format::prdid} : std::nullopt;
  }
  if (is_sentence(datagram, nmea::Kind::attitude)) return Format::psxn;
  if (choice_in_nmeap(datagram)) return Format::nmeap;
  if (tss1::decode(datagram).ok()) return Format::tss1;
  return em_format(datagram);
}

void FormatDetector::take(Bytes datagram) noexcept {
  ++datagrams_;
  size_ = datagram.size();
  const std::optional<Format> format = looks_like(datagram);
  if (!format) return;
  ++counts_[static_cast<std::size_t>(*format)];
  if (const auto choice = choice_in(datagram, *format)) {
    token_ = choice->token;
    variables_ = choice->variables;
  }
}

std::optional<Format> FormatDetector::format() const noexcept {
  for (const Format format : kFormats) {
    const bool weak = format == Format::em3000 || format == Format::em1000;
    const std::uint64_t seen = count(format);
    if (seen >= (weak ? kNeededOfWeak : kNeededOfStrong) && 10 * seen > 9 * datagrams_) return format;
  }
  return std::nullopt;
}

}  // namespace motionlab::mru

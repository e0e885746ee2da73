/// @file  Golden datagrams of the formats besides MRUBIN (that one: mru_frames.hpp), independent of our
/// encoders.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "drivers/core/bytes.hpp"
#include "drivers/mru/mru_wire_motion.hpp"
#include "tests/mru/mru_frames.hpp"

namespace motionlab::mru {

/// Constructed from the layout in the Kongsberg EK80 help.
inline constexpr std::array<std::uint8_t, 132> kKmFrame{
    0x23, 0x4B, 0x4D, 0x42, 0x84, 0x00, 0x01, 0x00, 0x00, 0xF1, 0x53, 0x65, 0x80, 0xB2, 0xE6, 0x0E, 0x00,
    0x00, 0x00, 0x00, 0xC2, 0x86, 0xA7, 0x57, 0xCA, 0x2A, 0x4D, 0x40, 0x81, 0x95, 0x43, 0x8B, 0x6C, 0x27,
    0x21, 0x40, 0x00, 0x00, 0x22, 0x42, 0x00, 0x00, 0xC0, 0x3F, 0x00, 0x00, 0x40, 0xBF, 0x00, 0x00, 0x87,
    0x43, 0x00, 0x00, 0x80, 0x3E, 0x00, 0x00, 0x00, 0x3F, 0x00, 0x00, 0x80, 0xBE, 0x00, 0x00, 0x00, 0x3E,
    0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x00, 0xC0, 0x00, 0x00, 0x80, 0x3D, 0x00, 0x00, 0x00, 0x3F, 0x00,
    0x00, 0x00, 0x3F, 0x00, 0x00, 0x80, 0x3F, 0x0A, 0xD7, 0xA3, 0x3C, 0x0A, 0xD7, 0xA3, 0x3C, 0xCD, 0xCC,
    0x4C, 0x3D, 0xCD, 0xCC, 0x4C, 0x3D, 0x00, 0x00, 0x00, 0x3E, 0x00, 0x00, 0x80, 0xBE, 0x00, 0x00, 0x00,
    0x3F, 0xF6, 0xF0, 0x53, 0x65, 0x00, 0x65, 0xCD, 0x1D, 0x00, 0x00, 0x00, 0xBE};

/// Constructed: roll 1.23 deg, pitch -0.45 deg, heave 0.67 m up, heading 270 deg.
inline constexpr std::array<std::uint8_t, 10> kEm3000Frame{0x90, 0x90, 0x7B, 0x00, 0xD3,
                                                           0xFF, 0x43, 0x00, 0x78, 0x69};
/// Constructed: the same as EM1000.
inline constexpr std::array<std::uint8_t, 10> kEm1000Frame{0x00, 0x90, 0x7B, 0x00, 0xD3,
                                                           0xFF, 0x43, 0x00, 0x78, 0x69};

/// Constructed from the layout in the Seapath 320 manual p. 101.
inline constexpr std::array<std::uint8_t, 44> kBin23Frame{
    0xAA, 0x51, 0x65, 0x53, 0xF1, 0x00, 0x09, 0xC4, 0x29, 0x7B, 0x6F, 0x6C, 0x06, 0x19, 0x65,
    0x2C, 0x00, 0x00, 0x0F, 0xD2, 0x00, 0x19, 0x00, 0x64, 0xFF, 0x38, 0x00, 0x06, 0x01, 0x11,
    0xFF, 0x77, 0xC0, 0x00, 0x00, 0x5B, 0xFF, 0xD2, 0x00, 0x17, 0x00, 0x00, 0x40, 0x37};

/// Published: a Seatex MRU on USCGC Healy (NCEI accession 0086548).
inline constexpr std::string_view kTss1Healy = ":000064 -0003U 0007 -0056\r\n";
/// Published: NovAtel's page on TSS1.
inline constexpr std::string_view kTss1Novatel = ":00FFCA -0003F-0325  0319\r\n";

/// Published: Seapath 320 manual p. 95 and users of it; the checksums hold.
inline constexpr std::string_view kPsxn20 = "$PSXN,20,0,0,0,0*3B\r\n";
inline constexpr std::string_view kPsxn23 = "$PSXN,23,1.28,1.93,104.68,-0.24*18\r\n";
inline constexpr std::string_view kPsxn23Level = "$PSXN,23,0.05,0.05,89.40,0.00*0D\r\n";
inline constexpr std::string_view kPsxn23Port = "$PSXN,23,-2.82,1.00,235.18,-1.66*3D\r\n";
/// Constructed.
inline constexpr std::string_view kPsxn24 = "$PSXN,24,0.50,-0.25,0.13,0.06*14\r\n";
inline constexpr std::string_view kPrdid = "$PRDID,-0.75,1.50,270.00*57\r\n";

/// Constructed: settled, token 11, roll 1.50 deg, pitch -0.75 deg, heave 0.25 m down.
inline constexpr std::string_view kNmeap = "$PSXN,10,011,1.50,-0.75,0.25*3A\r\n";
inline Layout nmeap_layout() {
  constexpr std::array kList{Variable::roll, Variable::pitch, Variable::pos_cg_d};
  return {.variables = VariableList::of(kList).value(), .limits = {}, .text_in_degrees = true};
}

/// Every golden datagram with the format that it is in.
struct Golden {
  Format format;
  ByteBuffer bytes;
  Layout layout{};
};

inline std::vector<Golden> all_golden() {
  const auto of = [](Format format, Bytes bytes, const Layout& layout = {}) {
    return Golden{format, {bytes.begin(), bytes.end()}, layout};
  };
  return {of(Format::mrubin, kLaboratoryFrame),     of(Format::km_binary, kKmFrame),
          of(Format::em3000, kEm3000Frame),         of(Format::em1000, kEm1000Frame),
          of(Format::tss1, as_bytes(kTss1Healy)),   of(Format::tss1, as_bytes(kTss1Novatel)),
          of(Format::psxn, as_bytes(kPsxn20)),      of(Format::psxn, as_bytes(kPsxn23)),
          of(Format::psxn, as_bytes(kPsxn23Level)), of(Format::psxn, as_bytes(kPsxn23Port)),
          of(Format::psxn, as_bytes(kPsxn24)),      of(Format::prdid, as_bytes(kPrdid)),
          of(Format::bin23, kBin23Frame),           of(Format::nmeap, as_bytes(kNmeap), nmeap_layout())};
}

}  // namespace motionlab::mru

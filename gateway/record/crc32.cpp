#include "gateway/record/crc32.hpp"

#include <array>
#include <cstddef>

namespace motionlab::record {
namespace {

/// Eight bytes at a time: table k is that of a byte with k more bytes behind it.
constexpr std::size_t kAtOnce = 8;
using Table = std::array<std::uint32_t, 256>;

constexpr std::array<Table, kAtOnce> make_tables() {
  constexpr std::uint32_t kPolynomial = 0xEDB88320;  // reflected
  std::array<Table, kAtOnce> tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? (crc >> 1) ^ kPolynomial : crc >> 1;
    tables[0][byte] = crc;
  }
  for (std::size_t k = 1; k < kAtOnce; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[k - 1][byte];
      tables[k][byte] = (before >> 8) ^ tables[0][before & 0xFF];
    }
  }
  return tables;
}

constexpr std::array<Table, kAtOnce> kTables = make_tables();

}  // namespace

std::uint32_t crc32(Bytes bytes, std::uint32_t crc) noexcept {
  crc = ~crc;
  while (bytes.size() >= kAtOnce) {
    const std::uint32_t low = load<std::uint32_t, std::endian::little>(bytes) ^ crc;
    const auto high = load<std::uint32_t, std::endian::little>(bytes.subspan(4));
    crc = kTables[7][low & 0xFF] ^ kTables[6][(low >> 8) & 0xFF] ^ kTables[5][(low >> 16) & 0xFF] ^
          kTables[4][low >> 24] ^ kTables[3][high & 0xFF] ^ kTables[2][(high >> 8) & 0xFF] ^
          kTables[1][(high >> 16) & 0xFF] ^ kTables[0][high >> 24];
    bytes = bytes.subspan(kAtOnce);
  }
  for (const std::uint8_t byte : bytes) crc = (crc >> 8) ^ kTables[0][(crc ^ byte) & 0xFF];
  return ~crc;
}

}  // namespace motionlab::record

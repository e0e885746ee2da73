/// @file  Sizes and units of a data packet that reading and writing share.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace motionlab::qualisys {

enum class TimecodeKind : std::uint32_t { smpte = 0, irig = 1, camera = 2 };

inline constexpr std::size_t kComponentHeaderSize = 8;
inline constexpr std::size_t kItemsHeadSize = 8;  ///< count, drop rate, out-of-sync rate
inline constexpr std::size_t kTimecodeItemSize = 12;
inline constexpr double kMetresPerMillimetre = 1e-3;
inline constexpr std::int64_t kNanosecondsPerTick = 100;
/// All bits set: what is not tracked.
inline constexpr float kLost = std::bit_cast<float>(0xFFFFFFFFu);

}  // namespace motionlab::qualisys

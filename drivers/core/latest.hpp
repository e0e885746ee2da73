/// @file  `Latest<T>`: one writer, any number of readers, nobody waits. The newest value, whole.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>

namespace motionlab {

/// Hands the newest value of one thread to others without a lock.
///
/// The writer fills the next of four slots and then names it; a reader copies the named slot and checks that
/// the writer has not come round to it meanwhile. A reader repeats only when it was overtaken by three whole
/// writes while copying, and gives up after a few such rounds (it then has nothing new to say). Before the
/// first write `read` yields nothing. Words are atomic, so that the race detector agrees.
template <class T>
requires std::is_trivially_copyable_v<T>
class Latest {
 public:
  /// Publishes a value. One thread only. Wait-free.
  void write(const T& value) noexcept {
    const std::uint64_t next = version_.load(std::memory_order_relaxed) + 1;
    Slot& slot = slots_[next % kSlots];
    slot.version.store(kBusy, std::memory_order_relaxed);
    std::array<Word, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    // Each word is released, so that whoever sees a new word also sees that the slot was busy.
    for (std::size_t i = 0; i < kWords; ++i) slot.words[i].store(words[i], std::memory_order_release);
    slot.version.store(next, std::memory_order_release);
    version_.store(next, std::memory_order_release);
  }

  /// A value and how many were written up to it.
  struct Sample {
    T value;
    std::uint64_t version;
  };

  /// The newest value; nothing before the first write.
  [[nodiscard]] std::optional<Sample> read() const noexcept {
    for (int attempt = 0; attempt < 16; ++attempt) {
      const std::uint64_t named = version_.load(std::memory_order_acquire);
      if (named == 0) return std::nullopt;
      const Slot& slot = slots_[named % kSlots];
      if (slot.version.load(std::memory_order_acquire) != named) continue;
      std::array<Word, kWords> words;
      for (std::size_t i = 0; i < kWords; ++i) words[i] = slot.words[i].load(std::memory_order_acquire);
      if (slot.version.load(std::memory_order_relaxed) != named) continue;
      std::optional<Sample> sample;
      sample.emplace();
      std::memcpy(static_cast<void*>(&sample->value), words.data(), sizeof(T));
      sample->version = named;
      return sample;
    }
    return std::nullopt;
  }

  /// The newest value if it is newer than `seen`, which is then moved on.
  [[nodiscard]] std::optional<T> read_newer(std::uint64_t& seen) const noexcept {
    if (version() == seen) return std::nullopt;
    const auto sample = read();
    if (!sample || sample->version == seen) return std::nullopt;
    seen = sample->version;
    return sample->value;
  }

  /// How many values were written so far.
  [[nodiscard]] std::uint64_t version() const noexcept { return version_.load(std::memory_order_acquire); }

 private:
  using Word = std::uint64_t;
  static constexpr std::size_t kSlots = 4;
  static constexpr std::size_t kWords = (sizeof(T) + sizeof(Word) - 1) / sizeof(Word);
  static constexpr std::uint64_t kBusy = ~std::uint64_t{0};

  struct Slot {
    std::atomic<std::uint64_t> version{0};
    std::array<std::atomic<Word>, kWords> words{};
  };

  std::array<Slot, kSlots> slots_{};
  alignas(64) std::atomic<std::uint64_t> version_{0};
};

}  // namespace motionlab

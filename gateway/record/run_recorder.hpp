/// @file  Writes a run down: the tape of the control thread into an MCAP file from which it can be run again.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "gateway/record/mcap_writer.hpp"
#include "gateway/record/run_tape.hpp"

namespace motionlab::record {

/// Names in the file.
inline constexpr std::string_view kRunMetadata = "motionlab/run";      ///< version, outputs_every
inline constexpr std::string_view kGapMetadata = "motionlab/gap";      ///< lost_steps, before_step
inline constexpr std::string_view kRunConfiguration = "gateway.toml";  ///< attachment: the effective text

/// The file has the effective configuration and the version first, then every step: `motionlab/snapshot` and
/// what was published, each message logged at the step's time. Steps that were lost are said where they are
/// missing. One thread; `drain` often enough that the tape does not fill.
class RunRecorder {
 public:
  /// At most so much, in laboratory time, is lost when the process dies.
  static constexpr Nanoseconds kChunk = 500ms;

  /// @param configuration  the effective text. @throws StartupError when the file cannot be made
  RunRecorder(const std::filesystem::path& file, RunTape& tape, std::string_view configuration,
              int zstd_level = 3);

  /// Writes what the tape has. @returns the number of steps
  std::size_t drain();
  /// Drains and ends the file.
  void finish();

  /// What keeps it from writing, as a sentence; nothing when all is well.
  [[nodiscard]] std::optional<std::string> trouble() const;
  /// The sentence for a file whose disk took no more.
  [[nodiscard]] static std::string full(const std::filesystem::path& file);
  [[nodiscard]] const std::filesystem::path& file() const noexcept { return file_; }

 private:
  void note_gap(std::uint64_t lost, std::uint64_t before_step);

  std::filesystem::path file_;
  RunTape& tape_;
  std::ofstream out_;
  McapWriter writer_;
  std::array<ChannelId, kRunKinds> channels_{};
  std::array<std::uint32_t, kRunKinds> counts_{};
  ByteBuffer step_;
  std::uint64_t lost_ = 0;
  std::uint64_t steps_ = 0;
  std::optional<LabTime> chunk_begun_;
};

/// `file`, or if that exists already, with the first free number behind its name: run-2.mcap. A recording is
/// never written over.
[[nodiscard]] std::filesystem::path unused_name(const std::filesystem::path& file);

}  // namespace motionlab::record

/// @file  `Recording`: samples of any topic into MCAP files, part after part, with a ledger of what is
/// missing.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/bytes.hpp"
#include "drivers/core/time.hpp"
#include "gateway/record/loss_ledger.hpp"
#include "gateway/record/mcap_writer.hpp"
#include "gateway/record/sample_queue.hpp"
#include "idl/health.hpp"

namespace motionlab::record {

/// Names in the file.
inline constexpr std::string_view kRecordingMetadata = "motionlab/recording";  ///< version, part, host
inline constexpr std::string_view kLossMetadata = "motionlab/losses";  ///< topic, messages, and what is lost
inline constexpr std::string_view kWireMetadata = "motionlab/wire";    ///< device, and what its link lost
inline constexpr std::string_view kOccasionMetadata = "motionlab/occasion";  ///< what a part was begun for

struct AttachedFile {
  std::string name;
  std::string media_type;
  std::string data;
};

struct RecordingOptions {
  std::filesystem::path file{};  ///< of the first part; an existing file is never touched
  std::uint64_t split_bytes = std::uint64_t{1} << 30;  ///< a part that is so long is the last of its kind
  std::uint64_t disk_bytes = 0;  ///< all parts together; the oldest are deleted; 0: no limit
  int zstd_level = 1;
  bool on_occasion = false;              ///< nothing is written before `begin`; else it begins at once
  StringMap about{};                     ///< for the metadata of each part
  std::vector<AttachedFile> attached{};  ///< to each part
};

/// Every part is a whole file: schemas, attachments, index, summary, and at its end the ledger of what this
/// part lacks. A part whose writer was killed lacks the last `kChunk` at most, and its end. A part ends when
/// it is long enough and the next begins; on occasion, parts begin and end when they are asked to.
///
/// Samples lie in the file as they came, with the time they were heard, the time they were written, and the
/// DDS number that their writer gave them. One thread.
class Recording {
 public:
  /// No sample waits longer for the file.
  static constexpr Nanoseconds kChunk = 500ms;

  /// @throws StartupError  the file cannot be made (on occasion: could not be made now)
  Recording(RecordingOptions options, LabTime now);

  /// Begins a part when none is open. @param occasion  its metadata says so
  void begin(LabTime now, StringMap occasion);
  /// Ends the part that is open, if one is.
  void end();

  /// Writes it down, where a part is open.
  void take(const SampleToRecord& sample, Bytes cdr);
  /// Does not write it down: the ledger of the next part begins behind it.
  void pass(const SampleToRecord& sample, Bytes cdr);
  /// Writes what has waited long enough. Call it some times a second.
  void keep_up(LabTime now);
  /// Ends the recording, and the part that is open. @param losses  all of them, since the beginning
  void finish(const LossesByTopic& losses);

  /// What keeps it from writing, as a sentence; nothing when all is well.
  [[nodiscard]] std::optional<std::string> trouble() const;
  [[nodiscard]] std::uint64_t messages() const noexcept { return messages_; }
  /// On disk, deleted parts not counted.
  [[nodiscard]] std::uint64_t bytes() const noexcept;
  /// The parts that are there, oldest first.
  [[nodiscard]] std::vector<std::filesystem::path> files() const;

 private:
  struct File {
    File(const std::filesystem::path& path, const McapWriterOptions& options)
        : out(path, std::ios::binary | std::ios::trunc), writer(out, options) {}
    std::ofstream out;
    McapWriter writer;
  };
  struct Channel {
    ChannelId id = 0;
    std::uint64_t messages = 0;
  };
  /// What a device's link told of itself in this part.
  struct Wire {
    topic::Health first, last;
  };
  struct EndedPart {
    std::filesystem::path path;
    std::uint64_t bytes;
  };

  void begin_part(LabTime now);
  void end_part();
  void learn(const SampleToRecord& sample, Bytes cdr);
  void put_ledger();
  void make_room();
  Channel& channel(std::size_t topic);

  RecordingOptions options_;
  std::filesystem::path path_;          ///< of the newest part
  std::optional<File> file_;            ///< of the part that is open
  std::optional<std::string> trouble_;  ///< that the last part ended with
  StringMap occasion_;
  std::uint64_t part_ = 0;
  std::deque<EndedPart> ended_;
  std::uint64_t messages_ = 0;
  LabTime chunk_ends_{};
  std::array<Channel, bus::kTopicList.size()> channels_{};
  LossesByTopic losses_{}, losses_before_{};  ///< by now, and when this part began
  std::map<std::string, Wire> wires_;
};

/// A name for a recording that begins now, by UTC: "motionlab-20261130T021500Z.mcap".
[[nodiscard]] std::string dated_name(LabTime now);

}  // namespace motionlab::record

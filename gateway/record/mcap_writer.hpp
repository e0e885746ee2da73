/// @file  Writes MCAP files: messages of any topic in compressed chunks, with every index and checksum of the
/// format.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/core/bytes.hpp"
#include "drivers/core/time.hpp"
#include "gateway/record/mcap_format.hpp"
#include "gateway/record/record_builder.hpp"

namespace motionlab::record {

struct McapWriterOptions {
  std::string profile;                    ///< of the MCAP registry; empty: none
  std::string library = "motionlab";      ///< who writes
  int zstd_level = 3;                     ///< 1 (fast) to 19 (small); 0: chunks are not compressed
  std::size_t chunk_bytes = 1024 * 1024;  ///< a chunk ends when it has so many, uncompressed
};

/// Writes one file to a stream, front to back; nothing written is ever changed. A file that ends early,
/// because its process died, is readable up to its last whole chunk.
///
/// The stream is only asked whether it still takes bytes: after it refused some (a full disk) nothing more is
/// written and `ok()` is false. One thread.
class McapWriter {
 public:
  McapWriter(std::ostream& out, McapWriterOptions options = {});
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// @param encoding  of the schema, e.g. "omgidl"
  [[nodiscard]] SchemaId add_schema(std::string_view name, std::string_view encoding, std::string_view text);
  /// @param encoding  of the messages, e.g. "cdr"
  [[nodiscard]] ChannelId add_channel(std::string_view topic, std::string_view encoding, SchemaId schema,
                                      const StringMap& metadata = {});

  /// @param sequence  the publisher's count of this channel's messages, so that a reader sees what is missing
  void message(ChannelId channel, std::uint32_t sequence, LabTime logged, LabTime published, Bytes data);
  /// A file within the file.
  void attachment(std::string_view name, std::string_view media_type, LabTime created, Bytes data);
  /// What is to be known of the recording, by name. May come more than once.
  void metadata(std::string_view name, const StringMap& values);

  /// Ends the chunk, so that all messages up to here reach the stream, which is flushed.
  void end_chunk();
  /// Ends the file: indexes, statistics, footer. Nothing may be written after that.
  void finish();

  /// Whether the stream took everything.
  [[nodiscard]] bool ok() const noexcept { return ok_; }
  /// How long the file is by now, without the chunk that is being filled.
  [[nodiscard]] std::uint64_t bytes_written() const noexcept { return position_; }
  /// Messages so far.
  [[nodiscard]] std::uint64_t message_count() const noexcept { return message_count_; }

 private:
  struct Span {
    std::uint64_t first_ns = 0;
    std::uint64_t last_ns = 0;
    bool empty = true;
    void include(std::uint64_t ns);
  };
  struct ChunkIndex {
    Span span;
    std::uint64_t start = 0;
    std::uint64_t length = 0;
    std::map<ChannelId, std::uint64_t> message_indexes;
    std::uint64_t message_indexes_length = 0;
    std::uint64_t compressed = 0;
    std::uint64_t uncompressed = 0;
  };
  struct AttachmentIndex {
    std::uint64_t start, length, created_ns, size;
    std::string name, media_type;
  };
  struct MetadataIndex {
    std::uint64_t start, length;
    std::string name;
  };
  struct Compressor;

  void put(Bytes bytes);
  void put(const RecordBuilder& record) { put(record.bytes()); }
  void put_summary();
  void put_chunk_index(RecordBuilder& to, const ChunkIndex& chunk) const;

  std::ostream& out_;
  McapWriterOptions options_;
  std::string_view compression_;
  std::unique_ptr<Compressor> compressor_;
  bool ok_ = true;
  bool finished_ = false;
  std::uint64_t position_ = 0;
  std::uint32_t crc_ = 0;  ///< of all bytes since the file or its summary began

  RecordBuilder record_;    ///< the one that is being made
  RecordBuilder schemas_;   ///< all of them, once more for the summary
  RecordBuilder channels_;  ///< likewise
  RecordBuilder chunk_;     ///< the messages of the chunk that is being filled
  Span chunk_span_;
  std::map<ChannelId, std::vector<std::pair<std::uint64_t, std::uint64_t>>>
      chunk_messages_;  ///< time, offset

  SchemaId schema_count_ = 0;
  ChannelId channel_count_ = 0;
  Span span_;
  std::uint64_t message_count_ = 0;
  std::map<ChannelId, std::uint64_t> channel_message_counts_;
  std::vector<ChunkIndex> chunks_;
  std::vector<AttachmentIndex> attachments_;
  std::vector<MetadataIndex> metadata_;
};

}  // namespace motionlab::record

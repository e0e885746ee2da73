/// @file  Reads MCAP files from the front, trusting nothing in them.
#pragma once

#include <cstdint>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "gateway/record/mcap_format.hpp"

namespace motionlab::record {

struct McapSchema {
  std::string name;
  std::string encoding;
  std::string text;
};

struct McapChannel {
  std::string topic;
  std::string encoding;                ///< of the messages
  const McapSchema* schema = nullptr;  ///< null: none
  StringMap metadata;
};

struct McapMessage {
  const McapChannel* channel;
  std::uint32_t sequence;
  std::uint64_t logged_ns;
  std::uint64_t published_ns;
  Bytes data;  ///< lives until the next call
};

struct McapAttachment {
  std::string name;
  std::string media_type;
  std::uint64_t created_ns;
  Bytes data;  ///< lives until the next call
};

struct McapMetadata {
  std::string name;
  StringMap values;
};

using McapItem = std::variant<McapMessage, McapAttachment, McapMetadata>;

/// Goes through one file, front to back, without its indexes: a file whose writer died is read up to its last
/// whole record. Whatever the bytes are, a call ends with an item, with the end, or with a fault; after a
/// fault it says the same again. Takes memory for one record and one unpacked chunk, each limited.
class McapReader {
 public:
  /// No record is longer, and no chunk is larger when it is unpacked.
  static constexpr std::uint64_t kLargest = 64 * 1024 * 1024;

  /// @param in  a stream that can be asked for its length; outlives this
  explicit McapReader(std::istream& in);
  McapReader(const McapReader&) = delete;
  McapReader& operator=(const McapReader&) = delete;

  /// The next message, attachment or metadata in the file's order; nothing at its end.
  [[nodiscard]] Result<std::optional<McapItem>> next();

  /// After a fault: goes on behind the record that is damaged. @returns false when nobody knows where that
  /// ends
  bool skip();

  /// After the end: whether the file was finished. If not, it was cut off, as by a writer that died.
  [[nodiscard]] bool complete() const noexcept { return complete_; }
  /// After the end of a finished file: whether it has an index, so that others need not read it all.
  [[nodiscard]] bool has_index() const noexcept { return has_index_; }
  /// Where the last record that was read ended, in bytes from the front.
  [[nodiscard]] std::uint64_t position() const noexcept { return position_; }
  [[nodiscard]] const std::string& profile() const noexcept { return profile_; }
  [[nodiscard]] const std::string& library() const noexcept { return library_; }
  [[nodiscard]] const std::map<ChannelId, McapChannel>& channels() const noexcept { return channels_; }

 private:
  using Item = std::optional<McapItem>;
  /// What a record led to: an item; nothing, go on; or a fault.
  using Step = Result<Item>;

  Step read_start();
  Step read_record();
  Step take(Opcode opcode, Bytes content);
  Step take_chunk(Bytes content);
  Step take_from_chunk();
  Step take_schema(Bytes content);
  Step take_channel(Bytes content);
  Step take_message(Bytes content);
  /// @param crc  of the summary, up to where the footer tells its own
  Step take_footer(Bytes content, std::uint32_t crc);
  Step fail(Fault fault);
  Step give_up(Fault fault);
  /// Reads n bytes; false when there are fewer.
  bool read_bytes(std::uint64_t n, ByteBuffer& into);

  std::istream& in_;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
  std::uint32_t crc_ = 0;  ///< of the data, and then of the summary, up to the record that is being read
  bool started_ = false;
  bool in_summary_ = false;
  bool ended_ = false;
  bool complete_ = false;
  bool has_index_ = false;
  bool hopeless_ = false;  ///< where the next record begins is not known
  std::optional<Fault> fault_;

  ByteBuffer record_;
  ByteBuffer chunk_;
  std::size_t chunk_position_ = 0;
  std::string profile_, library_;
  std::map<SchemaId, McapSchema> schemas_;
  std::map<ChannelId, McapChannel> channels_;
};

}  // namespace motionlab::record

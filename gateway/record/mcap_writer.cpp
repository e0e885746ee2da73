#include "gateway/record/mcap_writer.hpp"

#include <zstd.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <new>
#include <stdexcept>

#include "gateway/record/crc32.hpp"

namespace motionlab::record {
namespace {

std::uint64_t unsigned_ns(LabTime t) {
  return static_cast<std::uint64_t>(to_ns(t));
}

template <class Id>
Id next_id(Id& count) {
  if (count == std::numeric_limits<Id>::max())
    throw std::length_error("an MCAP file has 16 bits for its ids");
  return ++count;
}

}  // namespace

/// zstd with its tables kept from chunk to chunk.
struct McapWriter::Compressor {
  explicit Compressor(int level_in) : level(level_in), context(ZSTD_createCCtx()) {
    if (!context) throw std::bad_alloc();
  }
  ~Compressor() { ZSTD_freeCCtx(context); }
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;

  Bytes compress(Bytes from) {
    buffer.resize(ZSTD_compressBound(from.size()));
    const std::size_t size =
        ZSTD_compressCCtx(context, buffer.data(), buffer.size(), from.data(), from.size(), level);
    assert(!ZSTD_isError(size));  // the buffer is large enough, nothing else can be wrong
    return Bytes{buffer}.first(size);
  }

  int level;
  ZSTD_CCtx* context;
  ByteBuffer buffer;
};

void McapWriter::Span::include(std::uint64_t ns) {
  first_ns = empty ? ns : std::min(first_ns, ns);
  last_ns = empty ? ns : std::max(last_ns, ns);
  empty = false;
}

McapWriter::McapWriter(std::ostream& out, McapWriterOptions options)
    : out_(out),
      options_(std::move(options)),
      compression_(options_.zstd_level > 0 ? kZstd : kNoCompression) {
  if (options_.zstd_level > 0) compressor_ = std::make_unique<Compressor>(options_.zstd_level);
  put(kMcapMagic);
  record_.clear();
  record_.begin(Opcode::header);
  record_.put_text(options_.profile);
  record_.put_text(options_.library);
  record_.end();
  put(record_);
}

McapWriter::~McapWriter() = default;

void McapWriter::put(Bytes bytes) {
  if (!ok_) return;
  out_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  ok_ = out_.good();
  position_ += bytes.size();
  crc_ = crc32(bytes, crc_);
}

SchemaId McapWriter::add_schema(std::string_view name, std::string_view encoding, std::string_view text) {
  const SchemaId id = next_id(schema_count_);
  record_.clear();
  record_.begin(Opcode::schema);
  record_.put(id);
  record_.put_text(name);
  record_.put_text(encoding);
  record_.put_text(text);
  record_.end();
  put(record_);
  schemas_.put_bytes(record_.bytes());
  return id;
}

ChannelId McapWriter::add_channel(std::string_view topic, std::string_view encoding, SchemaId schema,
                                  const StringMap& metadata) {
  const ChannelId id = next_id(channel_count_);
  record_.clear();
  record_.begin(Opcode::channel);
  record_.put(id);
  record_.put(schema);
  record_.put_text(topic);
  record_.put_text(encoding);
  record_.put_map(metadata);
  record_.end();
  put(record_);
  channels_.put_bytes(record_.bytes());
  return id;
}

void McapWriter::message(ChannelId channel, std::uint32_t sequence, LabTime logged, LabTime published,
                         Bytes data) {
  const std::uint64_t t = unsigned_ns(logged);
  chunk_messages_[channel].emplace_back(t, chunk_.size());
  chunk_span_.include(t);
  span_.include(t);
  ++message_count_;
  ++channel_message_counts_[channel];
  chunk_.begin(Opcode::message);
  chunk_.put(channel);
  chunk_.put(sequence);
  chunk_.put(t);
  chunk_.put(unsigned_ns(published));
  chunk_.put_bytes(data);
  chunk_.end();
  if (chunk_.size() >= options_.chunk_bytes) end_chunk();
}

void McapWriter::attachment(std::string_view name, std::string_view media_type, LabTime created, Bytes data) {
  const std::uint64_t start = position_;
  record_.clear();
  record_.begin(Opcode::attachment);
  const std::size_t head = record_.size();
  record_.put(unsigned_ns(created));  // logged when it was made
  record_.put(unsigned_ns(created));
  record_.put_text(name);
  record_.put_text(media_type);
  record_.put(static_cast<std::uint64_t>(data.size()));
  record_.put_bytes(data);
  record_.put(crc32(record_.bytes().subspan(head)));
  record_.end();
  put(record_);
  attachments_.push_back(
      {start, record_.size(), unsigned_ns(created), data.size(), std::string(name), std::string(media_type)});
}

void McapWriter::metadata(std::string_view name, const StringMap& values) {
  const std::uint64_t start = position_;
  record_.clear();
  record_.begin(Opcode::metadata);
  record_.put_text(name);
  record_.put_map(values);
  record_.end();
  put(record_);
  metadata_.push_back({start, record_.size(), std::string(name)});
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  const Bytes content = compressor_ ? compressor_->compress(chunk_.bytes()) : chunk_.bytes();
  ChunkIndex index;
  index.span = chunk_span_;
  index.start = position_;
  index.compressed = content.size();
  index.uncompressed = chunk_.size();
  record_.clear();
  record_.begin(Opcode::chunk);
  record_.put(chunk_span_.first_ns);
  record_.put(chunk_span_.last_ns);
  record_.put(index.uncompressed);
  record_.put(crc32(chunk_.bytes()));
  record_.put_text(compression_);
  record_.put(index.compressed);
  record_.end_with(content.size());
  put(record_);
  put(content);
  index.length = position_ - index.start;

  for (auto& [channel, messages] : chunk_messages_) {
    if (messages.empty()) continue;
    index.message_indexes[channel] = position_;
    record_.clear();
    record_.begin(Opcode::message_index);
    record_.put(channel);
    record_.put_sized([this, &at = messages] {
      for (const auto& [t, offset] : at) {
        record_.put(t);
        record_.put(offset);
      }
    });
    record_.end();
    put(record_);
    messages.clear();
  }
  index.message_indexes_length = position_ - index.start - index.length;
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_span_ = {};
  if (ok_) ok_ = out_.flush().good();
}

void McapWriter::put_chunk_index(RecordBuilder& to, const ChunkIndex& chunk) const {
  to.begin(Opcode::chunk_index);
  to.put(chunk.span.first_ns);
  to.put(chunk.span.last_ns);
  to.put(chunk.start);
  to.put(chunk.length);
  to.put_sized([&] {
    for (const auto& [channel, offset] : chunk.message_indexes) {
      to.put(channel);
      to.put(offset);
    }
  });
  to.put(chunk.message_indexes_length);
  to.put_text(compression_);
  to.put(chunk.compressed);
  to.put(chunk.uncompressed);
  to.end();
}

void McapWriter::put_summary() {
  const std::uint64_t summary_start = position_;
  struct Group {
    Opcode opcode;
    std::uint64_t start, length;
  };
  std::vector<Group> groups;
  const auto put_group = [&](Opcode opcode, Bytes records) {
    if (records.empty()) return;
    groups.push_back({opcode, position_, records.size()});
    put(records);
  };
  crc_ = 0;
  put_group(Opcode::schema, schemas_.bytes());
  put_group(Opcode::channel, channels_.bytes());

  record_.clear();
  record_.begin(Opcode::statistics);
  record_.put(message_count_);
  record_.put(schema_count_);
  record_.put(static_cast<std::uint32_t>(channel_count_));
  record_.put(static_cast<std::uint32_t>(attachments_.size()));
  record_.put(static_cast<std::uint32_t>(metadata_.size()));
  record_.put(static_cast<std::uint32_t>(chunks_.size()));
  record_.put(span_.first_ns);
  record_.put(span_.last_ns);
  record_.put_sized([this] {
    for (const auto& [channel, count] : channel_message_counts_) {
      record_.put(channel);
      record_.put(count);
    }
  });
  record_.end();
  put_group(Opcode::statistics, record_.bytes());

  record_.clear();
  for (const auto& chunk : chunks_) put_chunk_index(record_, chunk);
  put_group(Opcode::chunk_index, record_.bytes());

  record_.clear();
  for (const auto& attached : attachments_) {
    record_.begin(Opcode::attachment_index);
    record_.put(attached.start);
    record_.put(attached.length);
    record_.put(attached.created_ns);
    record_.put(attached.created_ns);
    record_.put(attached.size);
    record_.put_text(attached.name);
    record_.put_text(attached.media_type);
    record_.end();
  }
  put_group(Opcode::attachment_index, record_.bytes());

  record_.clear();
  for (const auto& known : metadata_) {
    record_.begin(Opcode::metadata_index);
    record_.put(known.start);
    record_.put(known.length);
    record_.put_text(known.name);
    record_.end();
  }
  put_group(Opcode::metadata_index, record_.bytes());

  const std::uint64_t offsets_start = position_;
  record_.clear();
  for (const auto& group : groups) {
    record_.begin(Opcode::summary_offset);
    record_.put(static_cast<std::uint8_t>(group.opcode));
    record_.put(group.start);
    record_.put(group.length);
    record_.end();
  }
  put(record_);

  record_.clear();
  record_.begin(Opcode::footer);
  record_.put(summary_start);
  record_.put(offsets_start);
  record_.end_with(4);
  record_.put(crc32(record_.bytes(), crc_));  // of the summary and of the footer up to here
  put(record_);
}

void McapWriter::finish() {
  if (finished_) return;
  finished_ = true;
  end_chunk();
  const std::uint32_t data_crc = crc_;
  record_.clear();
  record_.begin(Opcode::data_end);
  record_.put(data_crc);
  record_.end();
  put(record_);
  put_summary();
  put(kMcapMagic);
  if (ok_) ok_ = out_.flush().good();
}

}  // namespace motionlab::record

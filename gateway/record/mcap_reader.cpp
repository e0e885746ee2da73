#include "gateway/record/mcap_reader.hpp"

#include <zstd.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <new>
#include <utility>

#include "gateway/record/crc32.hpp"

namespace motionlab::record {
namespace {

constexpr Fault kTruncatedRecord{Reason::too_short,
                                 "a record is shorter than its fields; the file is damaged"};
constexpr Fault kTooLarge{
    Reason::too_long, "a record or chunk is larger than 64 MiB; write the file again with smaller chunks"};
constexpr Fault kBadChecksum{Reason::bad_checksum, "a checksum does not match; the file is damaged"};

/// As many as `McapWriter` can number.
constexpr std::size_t kMaxChannels = std::numeric_limits<ChannelId>::max();
/// Bytes of the footer that its checksum covers.
constexpr std::size_t kFooterTold = 8 + 8;

/// 32 bits of length, then the text.
std::string read_text(LittleReader& from) {
  const auto size = from.read<std::uint32_t>();
  return std::string(as_text(from.take(size)));
}

StringMap read_map(LittleReader& from) {
  const auto size = from.read<std::uint32_t>();
  LittleReader inner(from.take(size));
  StringMap map;
  while (inner.ok() && inner.remaining() > 0) {
    std::string key = read_text(inner);
    map[std::move(key)] = read_text(inner);
  }
  if (!inner.ok()) from.skip(from.remaining() + 1);  // the outer one is damaged, too
  return map;
}

/// Unpacks step by step, so that a lie about the size costs no more memory than what really comes out.
Status unpack_zstd(Bytes from, std::uint64_t size, ByteBuffer& into) {
  constexpr Fault kNotZstd{Reason::bad_value, "a chunk cannot be unpacked; the file is damaged"};
  constexpr std::size_t kAtOnce = 256 * 1024;
  struct Free {
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
  };
  const std::unique_ptr<ZSTD_DCtx, Free> context(ZSTD_createDCtx());
  if (!context) throw std::bad_alloc();
  ZSTD_inBuffer in{from.data(), from.size(), 0};
  into.clear();
  for (;;) {
    const std::size_t had = into.size();
    into.resize(had + std::min<std::uint64_t>(kAtOnce, size - had) +
                1);  // one more, to see that it is too long
    ZSTD_outBuffer out{into.data() + had, into.size() - had, 0};
    const std::size_t left = ZSTD_decompressStream(context.get(), &out, &in);
    into.resize(had + out.pos);
    if (ZSTD_isError(left) || into.size() > size) return kNotZstd;
    const bool stuck = out.pos == 0 && in.pos == in.size;
    if (left == 0 && in.pos == in.size) break;
    if (stuck) return kNotZstd;
  }
  if (into.size() != size) return kNotZstd;
  return Done{};
}

}  // namespace

McapReader::McapReader(std::istream& in) : in_(in) {
  in_.seekg(0, std::ios::end);
  const auto size = in_.tellg();
  size_ = size < 0 ? 0 : static_cast<std::uint64_t>(size);
  in_.seekg(0);
}

bool McapReader::read_bytes(std::uint64_t n, ByteBuffer& into) {
  if (n > size_ - position_) return false;
  into.resize(n);
  in_.read(reinterpret_cast<char*>(into.data()), static_cast<std::streamsize>(n));
  return static_cast<std::uint64_t>(in_.gcount()) == n;
}

McapReader::Step McapReader::fail(Fault fault) {
  fault_ = fault;
  return fault;
}

McapReader::Step McapReader::give_up(Fault fault) {
  hopeless_ = true;
  return fault;
}

bool McapReader::skip() {
  if (!fault_ || hopeless_) return false;
  fault_.reset();
  return true;
}

Result<std::optional<McapItem>> McapReader::next() {
  if (fault_) return *fault_;
  if (!started_) {
    started_ = true;
    if (const Step begun = read_start(); !begun) return fail(begun.fault());
  }
  while (!ended_ || chunk_position_ < chunk_.size()) {
    Step step = chunk_position_ < chunk_.size() ? take_from_chunk() : read_record();
    if (!step) return fail(step.fault());
    if (*step) return step;
  }
  return Item{};
}

McapReader::Step McapReader::read_start() {
  if (!read_bytes(kMcapMagic.size(), record_) ||
      !std::equal(record_.begin(), record_.end(), kMcapMagic.begin()))
    return give_up({Reason::bad_header, "this is not an MCAP file"});
  position_ += record_.size();
  crc_ = crc32(record_);
  return Item{};
}

McapReader::Step McapReader::read_record() {
  ByteBuffer head;
  if (!read_bytes(kRecordHead, head)) {
    ended_ = true;  // cut off
    return Item{};
  }
  const auto opcode = static_cast<Opcode>(head[0]);
  const auto length = load<std::uint64_t, std::endian::little>(Bytes{head}.subspan(1));
  if (length > size_ - position_ - kRecordHead) {
    ended_ = true;  // cut off within it
    return Item{};
  }
  if (length > kLargest) return give_up(kTooLarge);
  position_ += kRecordHead;
  if (!read_bytes(length, record_)) return give_up({Reason::transport, "the file cannot be read"});
  position_ += length;
  const std::uint32_t crc_before = crc_;
  crc_ = crc32(record_, crc32(head, crc_));
  if (opcode == Opcode::data_end) {
    LittleReader from(record_);
    const auto crc = from.read<std::uint32_t>();
    in_summary_ = true;
    crc_ = 0;
    if (!from.ok()) return kTruncatedRecord;
    if (crc != 0 && crc != crc_before) return kBadChecksum;
    return Item{};
  }
  if (opcode == Opcode::footer) {
    const Bytes told = Bytes{record_}.first(std::min(record_.size(), kFooterTold));
    return take_footer(record_, crc32(told, crc32(head, crc_before)));
  }
  return take(opcode, record_);
}

McapReader::Step McapReader::take(Opcode opcode, Bytes content) {
  if (in_summary_) return Item{};  // says again what was seen
  LittleReader from(content);
  switch (opcode) {
    case Opcode::header:
      profile_ = read_text(from);
      library_ = read_text(from);
      if (!from.ok()) return kTruncatedRecord;
      return Item{};
    case Opcode::schema:
      return take_schema(content);
    case Opcode::channel:
      return take_channel(content);
    case Opcode::message:
      return take_message(content);
    case Opcode::chunk:
      return take_chunk(content);
    case Opcode::attachment: {
      McapAttachment attachment;
      from.skip(8);  // when it was logged
      attachment.created_ns = from.read<std::uint64_t>();
      attachment.name = read_text(from);
      attachment.media_type = read_text(from);
      attachment.data = from.take(from.read<std::uint64_t>());
      const std::size_t checked = from.position();
      const auto crc = from.read<std::uint32_t>();
      if (!from.ok()) return kTruncatedRecord;
      if (crc != 0 && crc != crc32(content.first(checked))) return kBadChecksum;
      return Item{std::move(attachment)};
    }
    case Opcode::metadata: {
      McapMetadata metadata;
      metadata.name = read_text(from);
      metadata.values = read_map(from);
      if (!from.ok()) return kTruncatedRecord;
      return Item{std::move(metadata)};
    }
    default:
      return Item{};  // an index, or something newer than this reader
  }
}

McapReader::Step McapReader::take_schema(Bytes content) {
  LittleReader from(content);
  const auto id = from.read<SchemaId>();
  McapSchema schema{read_text(from), read_text(from), {}};
  schema.text = read_text(from);
  if (!from.ok()) return kTruncatedRecord;
  if (id != 0) schemas_.try_emplace(id, std::move(schema));
  return Item{};
}

McapReader::Step McapReader::take_channel(Bytes content) {
  LittleReader from(content);
  const auto id = from.read<ChannelId>();
  const auto schema = from.read<SchemaId>();
  McapChannel channel;
  channel.topic = read_text(from);
  channel.encoding = read_text(from);
  channel.metadata = read_map(from);
  if (!from.ok()) return kTruncatedRecord;
  if (schema != 0) {
    const auto found = schemas_.find(schema);
    if (found == schemas_.end())
      return Fault{Reason::unexpected, "a channel comes before its schema; the file is damaged"};
    channel.schema = &found->second;
  }
  if (channels_.size() == kMaxChannels)
    return Fault{Reason::too_long, "the file has more channels than a file of ours can have"};
  channels_.try_emplace(id, std::move(channel));
  return Item{};
}

McapReader::Step McapReader::take_message(Bytes content) {
  LittleReader from(content);
  const auto id = from.read<ChannelId>();
  McapMessage message{};
  message.sequence = from.read<std::uint32_t>();
  message.logged_ns = from.read<std::uint64_t>();
  message.published_ns = from.read<std::uint64_t>();
  if (!from.ok()) return kTruncatedRecord;
  message.data = from.take(from.remaining());
  const auto found = channels_.find(id);
  if (found == channels_.end())
    return Fault{Reason::unexpected, "a message comes before its channel; the file is damaged"};
  message.channel = &found->second;
  return Item{message};
}

McapReader::Step McapReader::take_chunk(Bytes content) {
  LittleReader from(content);
  from.skip(16);  // first and last time
  const auto size = from.read<std::uint64_t>();
  const auto crc = from.read<std::uint32_t>();
  const std::string compression = read_text(from);
  const Bytes packed = from.take(from.read<std::uint64_t>());
  if (!from.ok()) return kTruncatedRecord;
  if (size > kLargest) return kTooLarge;
  chunk_position_ = 0;
  chunk_.clear();
  const auto refuse = [this](Fault fault) {
    chunk_.clear();
    return Step{fault};
  };
  if (compression == kZstd) {
    if (const Status unpacked = unpack_zstd(packed, size, chunk_); !unpacked) return refuse(unpacked.fault());
  } else if (compression == kNoCompression) {
    chunk_.assign(packed.begin(), packed.end());
  } else {
    return Fault{Reason::unexpected, "a chunk is packed by something else than zstd; write the file again"};
  }
  if (chunk_.size() != size) return refuse(kTruncatedRecord);
  if (crc != 0 && crc != crc32(chunk_)) return refuse(kBadChecksum);
  return Item{};
}

McapReader::Step McapReader::take_from_chunk() {
  LittleReader from(Bytes{chunk_}.subspan(chunk_position_));
  const auto opcode = static_cast<Opcode>(from.read<std::uint8_t>());
  const Bytes content = from.take(from.read<std::uint64_t>());
  chunk_position_ += from.position();  // to the end of the chunk when there is no whole record any more
  if (!from.ok()) return kTruncatedRecord;
  switch (opcode) {
    case Opcode::schema:
      return take_schema(content);
    case Opcode::channel:
      return take_channel(content);
    case Opcode::message:
      return take_message(content);
    default:
      return Item{};
  }
}

McapReader::Step McapReader::take_footer(Bytes content, std::uint32_t crc) {
  ended_ = true;
  LittleReader from(content);
  const auto summary_start = from.read<std::uint64_t>();
  from.skip(8);  // where the offsets begin
  const auto told = from.read<std::uint32_t>();
  if (!from.ok()) return kTruncatedRecord;
  if (told != 0 && told != crc)
    return Fault{Reason::bad_checksum, "the checksum of the summary does not match; the index is damaged"};
  if (!in_summary_)
    return Fault{Reason::unexpected, "the data has no end before the footer; the file is damaged"};
  if (!read_bytes(kMcapMagic.size(), record_)) return Item{};  // cut off in the last moment
  position_ += record_.size();
  if (!std::equal(record_.begin(), record_.end(), kMcapMagic.begin()))
    return Fault{Reason::bad_header, "the file does not end as an MCAP file; it is damaged"};
  complete_ = true;
  has_index_ = summary_start != 0;
  return Item{};
}

}  // namespace motionlab::record

#include "gateway/record/recording.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <numeric>
#include <system_error>
#include <utility>

#include "drivers/core/error.hpp"
#include "gateway/record/cdr.hpp"
#include "gateway/record/run_recorder.hpp"

namespace motionlab::record {
namespace {

constexpr std::size_t kMaxWires = 64;  // devices that tell of their links; a stranger may name any number

std::string utc(LabTime t, const char* format) {
  const std::time_t second = to_ns(t) / 1'000'000'000;
  std::tm parts{};
  gmtime_r(&second, &parts);
  std::array<char, 64> text{};
  return {text.data(), std::strftime(text.data(), text.size(), format, &parts)};
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

/// How far a counter of a device has come in a part. It begins again with the gateway.
std::uint64_t grown(std::uint64_t first, std::uint64_t last) {
  return last >= first ? last - first : last;
}

}  // namespace

std::string dated_name(LabTime now) {
  return "motionlab-" + utc(now, "%Y%m%dT%H%M%SZ") + ".mcap";
}

Recording::Recording(RecordingOptions options, LabTime now) : options_(std::move(options)) {
  options_.file = unused_name(options_.file);
  options_.about["version"] = MOTIONLAB_VERSION;
  options_.about["host"] = host_name();
  begin_part(now);
  if (trouble()) {
    const int reason = errno;
    std::error_code ignored;  // nothing is in it
    std::filesystem::remove(path_, ignored);
    throw StartupError("cannot write the recording " + path_.string() + ": " + std::strerror(reason) +
                       "; choose a folder that exists and is writable, on a disk with room");
  }
  if (options_.on_occasion) {
    file_.reset();
    std::filesystem::remove(path_);
    part_ = 0;
  }
}

void Recording::begin(LabTime now, StringMap occasion) {
  if (file_ || trouble_) return;
  occasion_ = std::move(occasion);
  make_room();
  begin_part(now);
}

void Recording::end() {
  if (file_) end_part();
}

void Recording::begin_part(LabTime now) {
  ++part_;
  path_ = options_.file;
  if (part_ > 1) {
    path_ = unused_name(options_.file.parent_path() /
                        (options_.file.stem().string() + "-part" + std::to_string(part_) +
                         options_.file.extension().string()));
  }
  errno = 0;
  file_.emplace(path_, McapWriterOptions{.profile = {},
                                         .library = "motionlab " MOTIONLAB_VERSION,
                                         .zstd_level = options_.zstd_level});
  StringMap about = options_.about;
  about["part"] = std::to_string(part_);
  about["began"] = utc(now, "%Y-%m-%dT%H:%M:%SZ");
  file_->writer.metadata(kRecordingMetadata, about);
  if (!occasion_.empty()) file_->writer.metadata(kOccasionMetadata, occasion_);
  for (const AttachedFile& attached : options_.attached) {
    file_->writer.attachment(attached.name, attached.media_type, now, as_bytes(attached.data));
  }
  file_->out.flush();
  channels_ = {};
  losses_before_ = losses_;
  for (auto& [device, wire] : wires_) wire.first = wire.last;
  chunk_ends_ = now + kChunk;
}

Recording::Channel& Recording::channel(std::size_t topic) {
  Channel& channel = channels_[topic];
  if (channel.id == 0) {
    const bus::TopicRow& row = bus::kTopicList[topic];
    channel.id = file_->writer.add_channel(row.name, "cdr",
                                           file_->writer.add_schema(row.type_name, "omgidl", row.idl));
  }
  return channel;
}

void Recording::take(const SampleToRecord& sample, Bytes cdr) {
  if (!file_) return;
  Channel& to = channel(sample.topic);
  file_->writer.message(to.id, static_cast<std::uint32_t>(sample.sequence), from_ns(sample.t_heard_ns),
                        from_ns(sample.t_written_ns), cdr);
  ++to.messages;
  ++messages_;
  learn(sample, cdr);
}

void Recording::pass(const SampleToRecord& sample, Bytes cdr) {
  learn(sample, cdr);
}

void Recording::learn(const SampleToRecord& sample, Bytes cdr) {
  losses_[sample.topic] = sample.losses;
  topic::Health health;
  if (sample.topic == bus::topic_index<topic::Health>() && read_cdr(cdr, health, kDdsPadding)) {
    const std::string device = health.device.str();
    if (const auto known = wires_.find(device); known != wires_.end()) {
      known->second.last = health;
    } else if (wires_.size() < kMaxWires) {
      wires_.emplace(device, Wire{health, health});
    }
  }
}

void Recording::keep_up(LabTime now) {
  if (!file_ || trouble()) return;
  if (file_->writer.bytes_written() >= options_.split_bytes) {
    end_part();
    if (trouble_) return;
    make_room();
    begin_part(now);
  } else if (now >= chunk_ends_) {
    file_->writer.end_chunk();
    chunk_ends_ = now + kChunk;
  }
}

void Recording::put_ledger() {
  for (std::size_t topic = 0; topic < channels_.size(); ++topic) {
    const TopicLosses lost = losses_[topic] - losses_before_[topic];
    if (channels_[topic].messages == 0 && lost == TopicLosses{}) continue;
    file_->writer.metadata(kLossMetadata, {{"topic", std::string(bus::kTopicList[topic].name)},
                                           {"messages", std::to_string(channels_[topic].messages)},
                                           {"lost_on_dds", std::to_string(lost.on_dds)},
                                           {"lost_in_queue", std::to_string(lost.in_queue)},
                                           {"refused", std::to_string(lost.refused)}});
  }
  for (const auto& [device, wire] : wires_) {
    std::uint64_t rejected = 0;
    for (std::size_t reason = 0; reason < wire.last.rejected.size(); ++reason)
      rejected += grown(wire.first.rejected[reason], wire.last.rejected[reason]);
    file_->writer.metadata(
        kWireMetadata, {{"device", device},
                        {"received", std::to_string(grown(wire.first.received, wire.last.received))},
                        {"lost", std::to_string(grown(wire.first.lost, wire.last.lost))},
                        {"rejected", std::to_string(rejected)},
                        {"reconnects", std::to_string(grown(wire.first.reconnects, wire.last.reconnects))}});
  }
}

void Recording::end_part() {
  file_->writer.end_chunk();
  put_ledger();
  file_->writer.finish();
  file_->out.close();
  ended_.push_back({path_, file_->writer.bytes_written()});
  trouble_ = trouble();
  file_.reset();
}

void Recording::make_room() {
  if (options_.disk_bytes == 0) return;
  std::uint64_t used =
      std::accumulate(ended_.begin(), ended_.end(), options_.split_bytes,
                      [](std::uint64_t sum, const EndedPart& part) { return sum + part.bytes; });
  while (used > options_.disk_bytes && !ended_.empty()) {
    std::error_code ignored;  // somebody has moved it away: good as well
    std::filesystem::remove(ended_.front().path, ignored);
    used -= ended_.front().bytes;
    ended_.pop_front();
  }
}

void Recording::finish(const LossesByTopic& losses) {
  losses_ = losses;
  end();
}

std::optional<std::string> Recording::trouble() const {
  if (trouble_ || !file_) return trouble_;
  if (file_->writer.ok() && file_->out) return std::nullopt;
  return RunRecorder::full(path_);
}

std::uint64_t Recording::bytes() const noexcept {
  std::uint64_t sum = 0;
  for (const EndedPart& part : ended_) sum += part.bytes;
  return file_ ? sum + file_->writer.bytes_written() : sum;
}

std::vector<std::filesystem::path> Recording::files() const {
  std::vector<std::filesystem::path> files;
  for (const EndedPart& part : ended_) files.push_back(part.path);
  if (file_) files.push_back(path_);
  return files;
}

}  // namespace motionlab::record

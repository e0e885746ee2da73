#include "gateway/record/inspection.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "gateway/record/mcap_writer.hpp"

namespace motionlab::record {
namespace {

LabTime time_of(std::uint64_t ns) {
  return from_ns(static_cast<std::int64_t>(ns));
}

/// Writes into another file what a reader reads.
class Copy {
 public:
  explicit Copy(std::ostream& out, const std::string& library)
      : writer_(out, {.profile = {}, .library = library}) {}

  void operator()(const McapMessage& message) {
    writer_.message(channel(*message.channel), message.sequence, time_of(message.logged_ns),
                    time_of(message.published_ns), message.data);
  }
  void operator()(const McapAttachment& attachment) {
    writer_.attachment(attachment.name, attachment.media_type, time_of(attachment.created_ns),
                       attachment.data);
  }
  void operator()(const McapMetadata& metadata) { writer_.metadata(metadata.name, metadata.values); }

  void finish(const Inspection& seen) {
    writer_.end_chunk();
    writer_.metadata(kRepairMetadata, {{"complete", seen.complete ? "true" : "false"},
                                       {"damages", std::to_string(seen.damage_count)}});
    writer_.finish();
  }

 private:
  ChannelId channel(const McapChannel& of) {
    const auto [known, is_new] = channels_.try_emplace(&of, 0);
    if (is_new) known->second = writer_.add_channel(of.topic, of.encoding, schema(of.schema), of.metadata);
    return known->second;
  }
  SchemaId schema(const McapSchema* of) {
    if (!of) return 0;
    const auto [known, is_new] = schemas_.try_emplace(of, 0);
    if (is_new) known->second = writer_.add_schema(of->name, of->encoding, of->text);
    return known->second;
  }

  McapWriter writer_;
  std::map<const McapSchema*, SchemaId> schemas_;
  std::map<const McapChannel*, ChannelId> channels_;
};

/// Notes what a reader reads.
class Notes {
 public:
  explicit Notes(Inspection& to) : to_(to) {}

  void operator()(const McapMessage& message) {
    const auto [place, is_new] = places_.try_emplace(message.channel, to_.topics.size());
    if (is_new) {
      to_.topics.push_back({.topic = message.channel->topic,
                            .type = message.channel->schema ? message.channel->schema->name : "",
                            .first_ns = message.logged_ns,
                            .numbers = {}});
    }
    TopicContents& contents = to_.topics[place->second];
    ++contents.messages;
    contents.first_ns = std::min(contents.first_ns, message.logged_ns);
    contents.last_ns = std::max(contents.last_ns, message.logged_ns);
    contents.numbers.take(message.sequence);
  }
  void operator()(const McapAttachment& attachment) {
    to_.attachments.emplace_back(attachment.name, attachment.data.size());
  }
  void operator()(const McapMetadata& metadata) { to_.metadata.push_back(metadata); }

  void damage(const McapReader& reader, Fault fault) {
    ++to_.damage_count;
    if (to_.damages.size() < Inspection::kMaxDamages) to_.damages.push_back({reader.position(), fault.text});
  }

 private:
  Inspection& to_;
  std::map<const McapChannel*, std::size_t> places_;
};

template <class F>
Inspection read_all(McapReader& reader, F&& also) {
  Inspection seen;
  Notes notes(seen);
  for (;;) {
    const auto item = reader.next();
    if (!item) {
      notes.damage(reader, item.fault());
      if (!reader.skip()) break;
      continue;
    }
    if (!item->has_value()) break;
    std::visit(notes, **item);
    also(**item);
  }
  seen.library = reader.library();
  seen.complete = reader.complete();
  seen.has_index = reader.has_index();
  return seen;
}

}  // namespace

std::uint64_t Inspection::messages() const noexcept {
  std::uint64_t sum = 0;
  for (const TopicContents& contents : topics) sum += contents.messages;
  return sum;
}

Inspection inspect(std::istream& in) {
  McapReader reader(in);
  return read_all(reader, [](const McapItem&) {});
}

Inspection repair(std::istream& in, std::ostream& out) {
  McapReader reader(in);
  Copy copy(out, "motionlab " MOTIONLAB_VERSION);
  Inspection seen = read_all(reader, [&copy](const McapItem& item) { std::visit(copy, item); });
  copy.finish(seen);
  return seen;
}

}  // namespace motionlab::record

#include "gateway/console/board.hpp"

#include <utility>

namespace motionlab::console {
namespace {

using bus::kTopicList;
using bus::QosClass;

constexpr std::uint32_t channel_of(std::size_t topic) {
  return static_cast<std::uint32_t>(topic) + 1;
}

}  // namespace

Board::Change Board::look(LabTime now, const std::vector<bool>& written) {
  Change change;
  for (std::size_t topic = 0; topic < rows_.size(); ++topic) {
    Row& row = rows_[topic];
    if (written[topic]) row.written = now;
    const bool open = written[topic] || (row.open && now - row.written < kGoneAfter);
    if (open == row.open) continue;
    row.open = open;
    (open ? change.come : change.gone).push_back(channel_of(topic));
    if (!open) {
      row.newest.clear();
      row.last.clear();
    }
  }
  return change;
}

Parcel Board::accept(std::size_t topic, std::string_view instance, LabTime now, Payload payload) {
  Row& row = rows_[topic];
  auto slot = row.slots.find(instance);
  if (slot == row.slots.end()) {
    const auto next = static_cast<std::uint32_t>(row.slots.size() < kSlots ? row.slots.size() : kSlots);
    if (next == kSlots) instance = "";
    slot = row.slots.try_emplace(std::string{instance}, next).first;
  }
  Parcel parcel{channel_of(topic), static_cast<std::uint32_t>(topic * (kSlots + 1)) + slot->second,
                to_ns(now), kTopicList[topic].every_sample_counts, std::move(payload)};
  if (kTopicList[topic].qos == QosClass::event) {
    row.last.push_back(parcel);
    if (row.last.size() > kEvents) row.last.pop_front();
  } else if (kTopicList[topic].qos == QosClass::state) {
    row.newest[parcel.slot] = parcel;
  }
  return parcel;
}

bool Board::open(std::uint32_t channel) const {
  return channel == kOwnChannel || (channel >= 1 && channel <= rows_.size() && rows_[channel - 1].open);
}

std::vector<std::uint32_t> Board::channels() const {
  std::vector<std::uint32_t> channels;
  for (std::uint32_t channel = 1; channel <= kOwnChannel; ++channel) {
    if (open(channel)) channels.push_back(channel);
  }
  return channels;
}

std::vector<Parcel> Board::remembered(std::uint32_t channel) const {
  std::vector<Parcel> parcels;
  if (channel < 1 || channel > rows_.size()) return parcels;
  const Row& row = rows_[channel - 1];
  for (const auto& [slot, parcel] : row.newest) parcels.push_back(parcel);
  parcels.insert(parcels.end(), row.last.begin(), row.last.end());
  return parcels;
}

}  // namespace motionlab::console

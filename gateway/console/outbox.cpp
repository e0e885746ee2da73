#include "gateway/console/outbox.hpp"

#include <algorithm>
#include <utility>

namespace motionlab::console {
namespace {

constexpr std::size_t kOverhead = 64;  // of a parcel, besides its payload

std::size_t size_of(const Parcel& parcel) {
  return parcel.payload->size() + kOverhead;
}

}  // namespace

void Outbox::push(Parcel parcel) {
  const bool full = bytes_ + size_of(parcel) > limit_;
  bytes_ += size_of(parcel);
  if (full || (newest_only_ && !parcel.every_counts)) {
    const auto older = std::ranges::find(parcels_, parcel.slot, &Parcel::slot);
    if (older != parcels_.end()) {
      if (full) {
        ++missed_;
        ++newly_missed_[older->channel];
      }
      bytes_ -= size_of(*older);
      if (std::ranges::find(older + 1, parcels_.end(), parcel.slot, &Parcel::slot) == parcels_.end()) {
        *older = std::move(parcel);
        return;
      }
      parcels_.erase(older);
    }
  }
  parcels_.push_back(std::move(parcel));
}

std::optional<Parcel> Outbox::pop() {
  if (parcels_.empty()) return std::nullopt;
  std::optional<Parcel> parcel{std::move(parcels_.front())};
  parcels_.pop_front();
  bytes_ -= size_of(*parcel);
  return parcel;
}

void Outbox::forget(std::uint32_t channel) {
  std::erase_if(parcels_, [&](const Parcel& parcel) {
    if (parcel.channel != channel) return false;
    bytes_ -= size_of(parcel);
    return true;
  });
}

std::map<std::uint32_t, std::uint64_t> Outbox::newly_missed() {
  return std::exchange(newly_missed_, {});
}

}  // namespace motionlab::console

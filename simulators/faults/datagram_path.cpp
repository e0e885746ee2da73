#include "simulators/faults/datagram_path.hpp"

#include <algorithm>
#include <utility>

namespace motionlab::faults {

Status DatagramPath::take(Bytes datagram, Endpoint peer, LabTime now) {
  if (faults_.spare_datagrams() && waiting_.empty() && !overtaken_) return exit_(datagram, peer, now, false);
  if (faults_.cut || is_lost()) return Done{};

  Parcel parcel{now, peer, false, {datagram.begin(), datagram.end()}};
  if (random_.chance(faults_.corrupt)) flip_one_bit(parcel.bytes);
  if (random_.chance(faults_.truncate) && !parcel.bytes.empty()) {
    parcel.bytes.resize(random_.below(static_cast<std::uint32_t>(parcel.bytes.size())));
  }
  const LabTime due =
      now +
      Nanoseconds{static_cast<std::int64_t>(static_cast<double>(faults_.jitter.count()) * random_.uniform())};
  if (!overtaken_ && random_.chance(faults_.reorder)) {
    overtaken_ = std::move(parcel);
    return Done{};
  }
  queue(parcel, due);
  if (random_.chance(faults_.duplicate)) queue(parcel, due);
  if (random_.chance(faults_.foreign)) {
    flip_one_bit(parcel.bytes);
    parcel.foreign = true;
    queue(std::move(parcel), due);
  }
  if (overtaken_) {
    queue(std::move(*overtaken_), due);
    overtaken_.reset();
  }
  step(now);
  return Done{};
}

void DatagramPath::step(LabTime now) {
  if (faults_.cut) {
    waiting_.clear();
    overtaken_.reset();
  }
  if (overtaken_ && faults_.reorder == 0) {
    queue(std::move(*overtaken_), now);
    overtaken_.reset();
  }
  while (!waiting_.empty() && waiting_.front().due <= now) {
    const Parcel parcel = std::move(waiting_.front());
    waiting_.pop_front();
    (void)exit_(parcel.bytes, parcel.peer, now, parcel.foreign);
  }
}

bool DatagramPath::is_lost() {
  if (still_to_lose_ > 0) {
    --still_to_lose_;
    return true;
  }
  // Nine of ten pass: between two runs lie nine times as many as in one.
  if (faults_.burst >= 1 && random_.chance(1 / (9 * faults_.burst))) {
    still_to_lose_ = static_cast<std::size_t>(faults_.burst) - 1;
    return true;
  }
  return random_.chance(faults_.loss);
}

void DatagramPath::flip_one_bit(ByteBuffer& bytes) {
  if (bytes.empty()) return;
  const std::uint32_t bit = random_.below(static_cast<std::uint32_t>(8 * bytes.size()));
  bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
}

void DatagramPath::queue(Parcel parcel, LabTime due) {
  parcel.due = waiting_.empty() ? due : std::max(due, waiting_.back().due);
  waiting_.push_back(std::move(parcel));
}

}  // namespace motionlab::faults

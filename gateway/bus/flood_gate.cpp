#include "gateway/bus/flood_gate.hpp"

namespace motionlab::bus {

bool GateWindow::begin(Time now) noexcept {
  if (now < end_) return false;
  end_ = now + kGateWindow;
  known_ = passed_ = 0;
  return true;
}

std::optional<std::size_t> GateWindow::passed_of(const Text<32>& requester) const noexcept {
  for (std::size_t i = 0; i < known_; ++i) {
    if (entries_[i].requester == requester) return entries_[i].passed;
  }
  return known_ < kRequesters ? std::optional<std::size_t>{0} : std::nullopt;
}

void GateWindow::count(const Text<32>& requester) noexcept {
  ++passed_;
  for (std::size_t i = 0; i < known_; ++i) {
    if (entries_[i].requester == requester) {
      ++entries_[i].passed;
      return;
    }
  }
  if (known_ < kRequesters) entries_[known_++] = {requester, 1};
}

bool RequestGate::passes(const topic::ModeRequest& request, Time now) noexcept {
  if (window_.begin(now)) settled_last_ = false;
  const bool settle = request.action == topic::ModeAction::settle;
  const auto of_him = window_.passed_of(request.requester);
  const bool turn =
      of_him && *of_him < kForOne &&
      (window_.passed() < kForAll || (*of_him == 0 && window_.passed() < kForAll + kForNewcomers));
  if (turn) window_.count(request.requester);
  if (turn || (settle && !settled_last_)) {
    settled_last_ = settle;
    if (settle_) ++refused_;
    settle_.reset();  // it was said before this one, and its work is done
    return true;
  }
  if (!settle || settle_) ++refused_;
  if (settle) settle_ = request;
  return false;
}

std::optional<topic::ModeRequest> RequestGate::held(Time now) noexcept {
  if (!settle_ || now < window_.end()) return std::nullopt;
  window_.begin(now);
  settled_last_ = true;
  const std::optional<topic::ModeRequest> settle = settle_;
  settle_.reset();
  return settle;
}

bool ReferenceGate::passes(const topic::Reference& reference, Time now) noexcept {
  if (window_.begin(now)) {
    if (newest_) ++refused_;  // this one is newer
    newest_.reset();
    return true;
  }
  if (newest_) ++refused_;
  newest_ = reference;
  return false;
}

std::optional<topic::Reference> ReferenceGate::held(Time now) noexcept {
  if (!newest_ || !window_.begin(now)) return std::nullopt;
  const std::optional<topic::Reference> newest = newest_;
  newest_.reset();
  return newest;
}

}  // namespace motionlab::bus

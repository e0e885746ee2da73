#include "gateway/monitor/progress.hpp"

#include <ostream>

#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/text.hpp"

namespace motionlab::monitor {

Progress::Progress(const Terminal& terminal, std::string what) : terminal_(terminal), what_(escaped(what)) {}

Progress::~Progress() {
  clear();
}

void Progress::show(Nanoseconds done, Nanoseconds all) {
  if (!terminal_.progress || done < next_) return;
  next_ = done + 200ms;
  terminal_.err << "\r" << what_ << ": " << fixed(seconds(done), 1) << " of " << fixed(seconds(all), 1)
                << " s\033[K" << std::flush;
  shown_ = true;
}

void Progress::clear() {
  if (shown_) terminal_.err << "\r\033[K" << std::flush;
  shown_ = false;
}

}  // namespace motionlab::monitor

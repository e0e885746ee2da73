#include "simulators/lab/study/replay_report.hpp"

#include <nlohmann/json.hpp>

namespace motionlab::study {

std::string replay_json(const service::ReplayOutcome& outcome) {
  nlohmann::ordered_json report{
      {"steps", outcome.steps},       {"outputs_compared", outcome.outputs_compared},
      {"equal", !outcome.difference}, {"cut_off", outcome.cut_off},
      {"version", outcome.version},   {"first_difference", nullptr}};
  if (const auto& d = outcome.difference) {
    report["first_difference"] = {{"since_step", d->since_step}, {"step", d->step},
                                  {"t_ns", to_ns(d->t)},         {"topic", d->topic},
                                  {"field", d->field},           {"recorded", d->recorded},
                                  {"replayed", d->replayed}};
  }
  return report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace motionlab::study

#include "tests/bench/recording.hpp"

#include "tests/unit/estimator/laboratory.hpp"

namespace motionlab::test {

Recording record(std::size_t periods) {
  Laboratory lab;
  Recording recording{belief_of(lab), std::vector<estimator::Inputs>(periods)};
  for (auto& inputs : recording.heard) {
    lab.step();
    inputs = lab.inputs();
  }
  return recording;
}

}  // namespace motionlab::test

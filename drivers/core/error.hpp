/// @file  What start-up throws: an error whose text says what is wrong and what to do.
#pragma once

#include <stdexcept>

namespace motionlab {

/// Anything that keeps a program from starting: a configuration, an address, a port in use.
class StartupError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace motionlab

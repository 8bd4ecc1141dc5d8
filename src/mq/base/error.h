#pragma once
/// Errors, as they cross the library's border. Every message says what was asked, what was
/// found and what to do next. A defect in a user's model is not an error but data (a report).

#include <stdexcept>
#include <string>

namespace mq {

/// The root of everything this library throws on purpose.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An argument or a model that cannot be worked with.
class InvalidInput : public Error {
 public:
  using Error::Error;
};

/// A file that cannot be read or written.
class IoError : public Error {
 public:
  using Error::Error;
};

/// A linear or nonlinear solver that cannot go on (a NaN, a matrix that is not positive definite).
/// A solver that merely did not converge says so in its report.
class SolverError : public Error {
 public:
  using Error::Error;
};

/// More memory is needed than there is (see base/memory.h).
class OutOfMemory : public Error {
 public:
  using Error::Error;
};

/// Something meaningful that this build or this version does not do.
class Unsupported : public Error {
 public:
  using Error::Error;
};

/// The caller asked to stop (`Progress`).
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

/// Throws `InvalidInput` with `message` unless `condition` holds.
inline void require(bool condition, const std::string& message) {
  if (!condition) throw InvalidInput(message);
}

/// The same for messages that are literals: nothing is built when the condition holds.
inline void require(bool condition, const char* message) {
  if (!condition) throw InvalidInput(message);
}

}  // namespace mq

// Checks that throw. Nothing in this project aborts: a broken contract or bad data becomes an
// exception whose text names what was wrong and where.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace tvl {

// A broken contract: the program is wrong.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Bad data or options: the input is wrong. The text names the file, frame or field.
class InputError : public Error {
 public:
  using Error::Error;
};

namespace internal {

// Collects a message and throws it as `E` at the end of the full expression.
template <typename E>
class Thrower {
 public:
  explicit Thrower(const std::string& prefix) { stream_ << prefix; }
  Thrower(const Thrower&) = delete;
  Thrower& operator=(const Thrower&) = delete;
  [[noreturn]] ~Thrower() noexcept(false) { throw E(stream_.str()); }
  template <typename T>
  Thrower& operator<<(const T& value) {
    stream_ << value;
    return *this;
  }

 private:
  std::ostringstream stream_;
};

}  // namespace internal
}  // namespace tvl

#define TVL_INTERNAL_STR2(x) #x
#define TVL_INTERNAL_STR(x) TVL_INTERNAL_STR2(x)

// Throws tvl::Error with the condition, the place and whatever is streamed after it.
#define TVL_CHECK(condition)                                                                       \
  if (condition) {                                                                                 \
  } else /* NOLINT */                                                                              \
    ::tvl::internal::Thrower<::tvl::Error>(__FILE__ ":" TVL_INTERNAL_STR(__LINE__) ": " #condition \
                                                                                   ": ")

// Throws tvl::InputError with whatever is streamed after it: for data and options.
#define TVL_CHECK_INPUT(condition) \
  if (condition) {                 \
  } else /* NOLINT */              \
    ::tvl::internal::Thrower<::tvl::InputError>("")

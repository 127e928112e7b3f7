#include "tvl/cli/frame_range.h"

#include <algorithm>
#include <charconv>

#include "tvl/base/check.h"

namespace tvl {
namespace {

size_t ParseIndex(const std::string& digits, const std::string& text, size_t if_empty) {
  if (digits.empty()) return if_empty;
  size_t value = 0;
  const char* end = digits.data() + digits.size();
  const auto parsed = std::from_chars(digits.data(), end, value);
  TVL_CHECK_INPUT(parsed.ec == std::errc() && parsed.ptr == end)
      << "--frames: want A:B, got '" << text << "'";
  return value;
}

}  // namespace

FrameRange ParseFrameRange(const std::string& text, size_t size) {
  if (text.empty()) return {0, size};
  const size_t colon = text.find(':');
  TVL_CHECK_INPUT(colon != std::string::npos) << "--frames: want A:B, got '" << text << "'";
  const size_t begin = ParseIndex(text.substr(0, colon), text, 0);
  const size_t end = std::min(size, ParseIndex(text.substr(colon + 1), text, size));
  TVL_CHECK_INPUT(begin < end) << "--frames: no frame in '" << text << "', the input has " << size;
  return {begin, end};
}

size_t FirstFrame(const std::string& text) {
  return ParseIndex(text.substr(0, std::min(text.find(':'), text.size())), text, 0);
}

}  // namespace tvl

#include "tvl/io/ros/compression.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Stored bytes are read in steps of this size: large enough to cost little, small enough that the
// start of a chunk is had without the rest.
constexpr size_t kStepBytes = size_t{1} << 16;
// The output grows in steps of this size, without being moved up to a compression by this ratio,
// which points and images do not reach.
constexpr uint64_t kGrowthBytes = uint64_t{1} << 20;
constexpr uint64_t kUsualRatio = 16;

struct Step {
  size_t read = 0, written = 0;
  bool finished = false;  // the end of the compressed stream
  const char* error = nullptr;
};

// One of the three libraries, as far as they are alike.
class Inflater {
 public:
  virtual ~Inflater() = default;
  virtual Step Run(const uint8_t* in, size_t in_bytes, uint8_t* out, size_t out_bytes) = 0;
};

class Bz2Inflater : public Inflater {
 public:
  Bz2Inflater() { TVL_CHECK(BZ2_bzDecompressInit(&stream_, 0, 0) == BZ_OK); }
  ~Bz2Inflater() override { BZ2_bzDecompressEnd(&stream_); }
  Step Run(const uint8_t* in, size_t in_bytes, uint8_t* out, size_t out_bytes) override {
    // The library does not write to its input, it only lacks the const.
    stream_.next_in = const_cast<char*>(reinterpret_cast<const char*>(in));
    stream_.avail_in = static_cast<unsigned>(in_bytes);
    stream_.next_out = reinterpret_cast<char*>(out);
    stream_.avail_out = static_cast<unsigned>(out_bytes);
    const int status = BZ2_bzDecompress(&stream_);
    const bool good = status == BZ_OK || status == BZ_STREAM_END;
    return {in_bytes - stream_.avail_in, out_bytes - stream_.avail_out, status == BZ_STREAM_END,
            good ? nullptr : "damaged bzip2 data"};
  }

 private:
  bz_stream stream_ = {};
};

class Lz4Inflater : public Inflater {
 public:
  Lz4Inflater() {
    TVL_CHECK(!LZ4F_isError(LZ4F_createDecompressionContext(&context_, LZ4F_VERSION)));
  }
  ~Lz4Inflater() override { LZ4F_freeDecompressionContext(context_); }
  Step Run(const uint8_t* in, size_t in_bytes, uint8_t* out, size_t out_bytes) override {
    size_t read = in_bytes, written = out_bytes;
    const size_t status = LZ4F_decompress(context_, out, &written, in, &read, nullptr);
    return {read, written, status == 0,
            LZ4F_isError(status) != 0U ? LZ4F_getErrorName(status) : nullptr};
  }

 private:
  LZ4F_dctx* context_ = nullptr;
};

class ZstdInflater : public Inflater {
 public:
  // The window a frame may ask for, as a power of two: what chunks may be large, no more.
  static constexpr int kMostWindowLog = 28;

  ZstdInflater() : context_(ZSTD_createDCtx()) {
    TVL_CHECK(context_ != nullptr);
    ZSTD_DCtx_setParameter(context_, ZSTD_d_windowLogMax, kMostWindowLog);
  }
  ~ZstdInflater() override { ZSTD_freeDCtx(context_); }
  Step Run(const uint8_t* in, size_t in_bytes, uint8_t* out, size_t out_bytes) override {
    ZSTD_inBuffer input = {in, in_bytes, 0};
    ZSTD_outBuffer output = {out, out_bytes, 0};
    const size_t status = ZSTD_decompressStream(context_, &output, &input);
    return {input.pos, output.pos, status == 0,
            ZSTD_isError(status) != 0U ? ZSTD_getErrorName(status) : nullptr};
  }

 private:
  ZSTD_DCtx* context_;
};

class CopyInflater : public Inflater {
 public:
  Step Run(const uint8_t* in, size_t in_bytes, uint8_t* out, size_t out_bytes) override {
    const size_t bytes = std::min(in_bytes, out_bytes);
    std::copy(in, in + bytes, out);
    return {bytes, bytes, false, nullptr};
  }
};

std::unique_ptr<Inflater> MakeInflater(Compression compression) {
  switch (compression) {
    case Compression::kNone:
      return std::make_unique<CopyInflater>();
    case Compression::kBz2:
      return std::make_unique<Bz2Inflater>();
    case Compression::kLz4:
      return std::make_unique<Lz4Inflater>();
    case Compression::kZstd:
      return std::make_unique<ZstdInflater>();
  }
  throw Error("compression that does not exist");
}

}  // namespace

Compression CompressionByName(const std::string& name, const std::string& source) {
  if (name.empty() || name == "none") return Compression::kNone;
  if (name == "bz2") return Compression::kBz2;
  if (name == "lz4") return Compression::kLz4;
  if (name == "zstd") return Compression::kZstd;
  throw InputError(source + ": compression '" + name.substr(0, 32) +
                   "' is not known (none, bz2, lz4, zstd are)");
}

const char* ToString(Compression compression) {
  switch (compression) {
    case Compression::kNone:
      return "none";
    case Compression::kBz2:
      return "bz2";
    case Compression::kLz4:
      return "lz4";
    case Compression::kZstd:
      return "zstd";
  }
  throw Error("compression that does not exist");
}

Inflated Inflate(const ByteSource& source, uint64_t offset, uint64_t stored_bytes,
                 Compression compression, uint64_t most_bytes) {
  Inflated inflated;
  const std::unique_ptr<Inflater> inflater = MakeInflater(compression);
  SourceCursor cursor(source, offset, offset + stored_bytes, kStepBytes);
  inflated.bytes.reserve(std::min(most_bytes, kUsualRatio * stored_bytes + kGrowthBytes));
  size_t written = 0;
  bool stuck = false;
  while (written < most_bytes && inflated.error.empty()) {
    if (inflated.bytes.size() == written) {
      inflated.bytes.resize(std::min<uint64_t>(most_bytes, written + kGrowthBytes));
    }
    const size_t in_bytes = std::min<uint64_t>(kStepBytes, cursor.remaining());
    const Step step =
        inflater->Run(cursor.Peek(in_bytes), in_bytes, inflated.bytes.data() + written,
                      inflated.bytes.size() - written);
    cursor.Skip(step.read);
    written += step.written;
    // Once without progress may be the library's own business, twice is the end.
    const bool idle = step.read == 0 && step.written == 0;
    if (step.error != nullptr) inflated.error = step.error;
    const bool ends = cursor.remaining() == 0 && (step.finished || step.written == 0);
    if (inflated.error.empty() && written < most_bytes && (ends || (idle && stuck))) {
      inflated.error = "the compressed data end early";
    }
    stuck = idle;
  }
  inflated.bytes.resize(written);
  return inflated;
}

}  // namespace tvl

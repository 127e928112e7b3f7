#include "tvl/io/cloud/bin_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr size_t kLeastFloats = 3, kMostFloats = 8;
constexpr size_t kSampledFiles = 5;
// A whole length must divide this share of the files: one that was cut off must not decide.
constexpr double kFileShare = 0.8;
constexpr size_t kFewNumbers = 200;
// Variances within columns. The right length and its multiples differ by less than 5 %; on real
// scans, shuffled ones too, the next wrong length is off by 20 % or more.
constexpr double kTie = 1.05, kDistinct = 1.1;
// Coordinates of this share must be numbers that a lidar delivers, in m or in mm. Bytes of other
// data, read as float32, have exponents all over the range.
constexpr double kPlausibleShare = 0.9;
constexpr float kLeastCoordinate = 1e-6F, kMostCoordinate = 1e6F;
// Times grow from point to point, but for the seams between rings.
constexpr double kGrowingShare = 0.97;
constexpr size_t kLeastTimes = 16;  // different ones, or it is a flag
constexpr float kMostRing = 255.0F;

using Column = std::vector<float>;

Column ColumnOf(const BinSample& sample, size_t floats, size_t column) {
  Column out;
  const size_t records = sample.numbers.size() / floats;
  for (size_t i = 0; i < records; ++i) out.push_back(sample.numbers[i * floats + column]);
  return out;
}

// Variance of the logarithms of the magnitudes: of numbers of one kind it is small, whatever their
// order. 0.01 stands for everything that is about zero.
double LogVariance(const Column& column) {
  double sum = 0.0, sum_sq = 0.0, n = 0.0;
  for (const float value : column) {
    if (!std::isfinite(value)) continue;
    const double x = std::log(std::abs(static_cast<double>(value)) + 0.01);
    sum += x, sum_sq += x * x, n += 1.0;
  }
  return n > 0.0 ? std::max(sum_sq / n - (sum / n) * (sum / n), 0.0) : 0.0;
}

// Mean of LogVariance over the columns of all samples.
double MixtureOf(const std::vector<BinSample>& samples, size_t floats) {
  double sum = 0.0;
  for (const BinSample& sample : samples) {
    for (size_t c = 0; c < floats; ++c) sum += LogVariance(ColumnOf(sample, floats, c));
  }
  return sum / static_cast<double>(floats * samples.size());
}

bool DividesFiles(const std::vector<BinSample>& samples, size_t floats) {
  size_t whole = 0;
  for (const BinSample& sample : samples) {
    whole += sample.file_bytes % (floats * sizeof(float)) == 0 ? 1 : 0;
  }
  return static_cast<double>(whole) >= kFileShare * static_cast<double>(samples.size());
}

bool AreCoordinates(const std::vector<BinSample>& samples, size_t floats) {
  size_t plausible = 0, all = 0;
  std::array<std::set<float>, 2> distinct;  // of x and y, two of each are enough
  for (const BinSample& sample : samples) {
    for (size_t c = 0; c < 3; ++c) {
      for (const float value : ColumnOf(sample, floats, c)) {
        const float size = std::abs(value);
        const bool good = !std::isnan(value) && size < kMostCoordinate &&
                          (size == 0.0F || size > kLeastCoordinate);
        plausible += good || std::isnan(value) ? 1 : 0;
        ++all;
        if (good && c < 2 && distinct[c].size() < 2) distinct[c].insert(value);
      }
    }
  }
  return static_cast<double>(plausible) >= kPlausibleShare * static_cast<double>(all) &&
         distinct[0].size() == 2 && distinct[1].size() == 2;
}

bool AreRings(const Column& column) {
  std::set<float> rings;
  for (const float value : column) {
    if (!(value >= 0.0F && value <= kMostRing && value == std::floor(value))) return false;
    rings.insert(value);
  }
  return rings.size() >= 2;
}

bool AreTimes(const Column& column) {
  std::set<float> times;
  size_t growing = 0;
  for (size_t i = 0; i < column.size(); ++i) {
    if (!std::isfinite(column[i])) return false;
    growing += i == 0 || column[i] >= column[i - 1] ? 1 : 0;
    if (times.size() < kLeastTimes) times.insert(column[i]);
  }
  return times.size() >= kLeastTimes &&
         static_cast<double>(growing) >= kGrowingShare * static_cast<double>(column.size());
}

bool AreIntensities(const Column& column) {
  return std::all_of(column.begin(), column.end(),
                     [](float value) { return value >= 0.0F && std::isfinite(value); });
}

template <typename Test>
bool HoldsForAll(const std::vector<BinSample>& samples, size_t floats, size_t column, Test test) {
  return std::all_of(samples.begin(), samples.end(), [&](const BinSample& sample) {
    return test(ColumnOf(sample, floats, column));
  });
}

BinLayout LayoutOf(const std::vector<BinSample>& samples, size_t floats) {
  BinLayout layout;
  layout.fields = {"x", "y", "z"};
  bool has_ring = false, has_time = false;
  for (size_t c = 3; c < floats; ++c) {
    std::string name = "unknown";
    if (c == 3 && HoldsForAll(samples, floats, c, AreIntensities)) {
      name = "intensity";
    } else if (c > 3 && !has_ring && HoldsForAll(samples, floats, c, AreRings)) {
      name = "ring";
      has_ring = true;
    } else if (c > 3 && !has_time && HoldsForAll(samples, floats, c, AreTimes)) {
      name = "time";
      has_time = true;
    }
    layout.fields.push_back(name);
  }
  layout.note = "records of " + std::to_string(floats) + " floats:";
  for (const std::string& field : layout.fields) layout.note += " " + field;
  return layout;
}

// 0: no length fits.
size_t ChooseFloats(const std::vector<BinSample>& samples) {
  std::array<double, kMostFloats + 1> mixture{};
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (size_t floats = kLeastFloats; floats <= kMostFloats; ++floats) {
    mixture[floats] = MixtureOf(samples, floats);
    most = std::max(most, mixture[floats]);
    if (DividesFiles(samples, floats)) least = std::min(least, mixture[floats]);
  }
  if (!(least * kDistinct <= most)) return 0;
  for (size_t floats = kLeastFloats; floats <= kMostFloats; ++floats) {
    if (DividesFiles(samples, floats) && mixture[floats] <= kTie * least) {
      return AreCoordinates(samples, floats) ? floats : 0;
    }
  }
  return 0;
}

// Four where it divides all files, else what does.
size_t ChooseFloatsOfFew(const std::vector<BinSample>& samples) {
  for (const size_t floats : std::array<size_t, 6>{4, 5, 3, 6, 7, 8}) {
    if (DividesFiles(samples, floats)) return floats;
  }
  return 0;
}

}  // namespace

BinLayout KittiBinLayout() {
  return {{"x", "y", "z", "intensity"}, "records of 4 floats: x y z intensity"};
}

BinSample SampleOfBin(const uint8_t* data, size_t bytes) {
  BinSample sample;
  sample.file_bytes = bytes;
  sample.numbers.resize(std::min(bytes / sizeof(float), kBinSampleNumbers));
  if (!sample.numbers.empty()) {
    std::memcpy(sample.numbers.data(), data, sample.numbers.size() * sizeof(float));
  }
  return sample;
}

BinLayout RecogniseBinLayout(const std::vector<BinSample>& all, const std::string& source) {
  std::vector<BinSample> samples;  // empty files tell nothing
  size_t numbers = 0;
  for (const BinSample& sample : all) {
    if (sample.numbers.empty()) continue;
    samples.push_back(sample);
    numbers += sample.numbers.size();
  }
  TVL_CHECK_INPUT(!samples.empty()) << source << ": no points";
  const bool few = numbers < kFewNumbers;
  const size_t floats = few ? ChooseFloatsOfFew(samples) : ChooseFloats(samples);
  TVL_CHECK_INPUT(floats > 0) << source << ": not points of 3 to 8 float32 numbers each that begin "
                              << "with x y z: no length of a record fits the file and its values";
  BinLayout layout = LayoutOf(samples, floats);
  if (few) layout.note += " (assumed: too few points to tell)";
  return layout;
}

BinLayout RecogniseBinFiles(const std::vector<std::string>& paths) {
  TVL_CHECK(!paths.empty());
  std::vector<BinSample> samples;
  for (size_t i = 0; i < paths.size() && samples.size() < kSampledFiles; ++i) {
    std::error_code error;
    const uintmax_t size = std::filesystem::file_size(paths[i], error);
    std::ifstream file(paths[i], std::ios::binary);
    if (error || !file.good()) continue;
    BinSample sample;
    sample.file_bytes = size;
    sample.numbers.resize(std::min<size_t>(size / sizeof(float), kBinSampleNumbers));
    const auto wanted = static_cast<std::streamsize>(sample.numbers.size() * sizeof(float));
    file.read(reinterpret_cast<char*>(sample.numbers.data()), wanted);
    if (file.gcount() == wanted) samples.push_back(std::move(sample));
  }
  TVL_CHECK_INPUT(!samples.empty()) << paths[0] << ": cannot be read";
  return RecogniseBinLayout(samples, paths[0]);
}

CloudRead ParseBinPoints(const uint8_t* data, size_t bytes, const BinLayout& layout,
                         const std::string& source) {
  PointTable table;
  for (const std::string& field : layout.fields) {
    table.fields.push_back({field, table.point_step, NumberType::kFloat32, 1});
    table.point_step += sizeof(float);
  }
  TVL_CHECK(table.point_step > 0) << "no fields";
  TVL_CHECK_INPUT(bytes % table.point_step == 0)
      << source << ": " << bytes << " bytes are no whole number of " << layout.fields.size()
      << " float32 a point: cut off?";
  table.width = bytes / table.point_step;
  table.data = data, table.bytes = bytes;
  CloudRead read;
  read.scan = DecodePoints(table, source);
  return read;
}

CloudRead ReadBinScan(const std::string& path, const BinLayout& layout) {
  const std::vector<uint8_t> bytes = ReadFileBytes(path);
  return ParseBinPoints(bytes.data(), bytes.size(), layout, path);
}

}  // namespace tvl

#include "tvl/io/cloud/bin_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tvl/base/units.h"
#include "tvl/io/cloud/test_bytes.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

using Record = std::vector<float>;

// A room of 12 x 8 m around a sensor of 16 rings, ring after ring; `more` gives the numbers after
// x y z for (ring, share of the turn).
template <typename More>
std::vector<Record> Room(const More& more) {
  std::vector<Record> records;
  for (int ring = 0; ring < 16; ++ring) {
    for (int column = 0; column < 90; ++column) {
      const double share = column / 90.0, azimuth_rad = 2.0 * kPi * share;
      const double c = std::cos(azimuth_rad), s = std::sin(azimuth_rad);
      const double range_m = 1.0 / std::max(std::abs(c) / 6.0, std::abs(s) / 4.0);
      Record record = {static_cast<float>(range_m * c), static_cast<float>(range_m * s),
                       static_cast<float>(range_m * std::tan(DegToRad(2.0 * ring - 15.0)))};
      for (const float value : more(ring, share)) record.push_back(value);
      records.push_back(record);
    }
  }
  return records;
}

std::string FileOf(const std::vector<Record>& records) {
  std::string file;
  for (const Record& record : records) {
    for (const float value : record) file += Bytes(value);
  }
  return file;
}

BinLayout Recognise(const std::vector<std::string>& files) {
  std::vector<BinSample> samples;
  for (const std::string& file : files) samples.push_back(SampleOfBin(DataOf(file), file.size()));
  return RecogniseBinLayout(samples, "a.bin");
}

std::string ErrorOf(const std::vector<std::string>& files) {
  return InputErrorOf([&] { Recognise(files); });
}

float Intensity(int ring, double share) {
  return static_cast<float>(0.3 + 0.2 * std::sin(40.0 * share + ring));
}

// Checks the fields of files with these numbers after x y z, in stored and in any order.
template <typename More>
void ExpectFields(const std::vector<std::string>& fields, const More& more, bool any_order = true) {
  std::vector<Record> records = Room(more);
  EXPECT_EQ(Recognise({FileOf(records)}).fields, fields);
  if (!any_order) return;
  std::shuffle(records.begin(), records.end(), std::mt19937(1));
  EXPECT_EQ(Recognise({FileOf(records)}).fields, fields);
}

TEST(BinPoints, RecognisesEveryLength) {
  ExpectFields({"x", "y", "z"}, [](int, double) { return Record(); });
  ExpectFields({"x", "y", "z", "intensity"},
               [](int ring, double share) { return Record{Intensity(ring, share)}; });
  ExpectFields({"x", "y", "z", "intensity"}, [](int, double) { return Record{0.0F}; });
  ExpectFields({"x", "y", "z", "intensity", "ring"}, [](int ring, double share) {
    return Record{std::floor(255.0F * Intensity(ring, share)), static_cast<float>(ring)};
  });
  ExpectFields({"x", "y", "z", "intensity", "unknown", "unknown", "unknown"},
               [](int ring, double share) {
                 return Record{Intensity(ring, share), 0.0F, 0.0F, 1.0F};
               });
}

TEST(BinPoints, RecognisesTimes) {
  ExpectFields(
      {"x", "y", "z", "intensity", "time", "ring"},
      [](int ring, double share) {
        return Record{Intensity(ring, share), static_cast<float>(0.1 * share),
                      static_cast<float>(ring)};
      },
      false);
  ExpectFields(
      {"x", "y", "z", "intensity", "ring", "time", "unknown", "unknown"},
      [](int ring, double share) {
        return Record{Intensity(ring, share), static_cast<float>(ring),
                      static_cast<float>(0.1 * share), 0.0F, 0.0F};
      },
      false);
}

TEST(BinPoints, OneCutOffFileDoesNotDecide) {
  const std::string whole = FileOf(Room([](int ring, double share) {
    return Record{Intensity(ring, share), static_cast<float>(ring)};
  }));
  const std::string cut = whole.substr(0, whole.size() - 8);
  EXPECT_EQ(Recognise({whole, cut, whole, whole, whole}).fields.size(), 5U);
  EXPECT_EQ(Recognise({whole, "", whole}).fields.size(), 5U);
}

TEST(BinPoints, AssumesKittiWhereThereIsLittle) {
  const std::string two = Bytes(1.0F, 2.0F, 3.0F, 0.5F) + Bytes(2.0F, 2.0F, 3.0F, 0.5F);
  const BinLayout layout = Recognise({two});
  EXPECT_THAT(layout.fields, ElementsAre("x", "y", "z", "intensity"));
  EXPECT_THAT(layout.note, HasSubstr("assumed"));
  EXPECT_EQ(Recognise({two.substr(0, 20)}).fields.size(), 5U);
  EXPECT_THAT(ErrorOf({"abc"}), HasSubstr("no points"));
}

TEST(BinPoints, RefusesWhatIsNoCloud) {
  std::mt19937 random(1);
  std::string noise, doubles, text;
  for (int i = 0; i < 4000; ++i) {
    noise += Bytes(static_cast<uint32_t>(random()));
    doubles += Bytes(0.001 * static_cast<double>(random() % 100000));
    text += std::to_string(random()) + "\n";
  }
  EXPECT_THAT(ErrorOf({noise}), StartsWith("a.bin: not points of 3 to 8 float32"));
  EXPECT_THAT(ErrorOf({doubles}), StartsWith("a.bin: not points"));
  EXPECT_THAT(ErrorOf({text}), StartsWith("a.bin: "));
  EXPECT_THAT(ErrorOf({std::string(16000, '\0')}), StartsWith("a.bin: not points"));
  EXPECT_THAT(ErrorOf({}), StartsWith("a.bin: no points"));
}

TEST(BinPoints, ReadsRecords) {
  BinLayout layout;
  layout.fields = {"x", "y", "z", "intensity", "ring", "unknown"};
  const std::string file = Bytes(1.0F, 2.0F, 3.0F, 0.5F, 7.0F, 9.0F) +
                           Bytes(4.0F, 5.0F, std::numeric_limits<float>::infinity(), 0.25F, 8.0F) +
                           Bytes(9.0F);
  const RawScan scan = ParseBinPoints(DataOf(file), file.size(), layout, "a.bin").scan;
  ASSERT_EQ(scan.size(), 2U);
  EXPECT_EQ(scan.points[0], Eigen::Vector3f(1.0F, 2.0F, 3.0F));
  EXPECT_THAT(scan.intensity, ElementsAre(0.5F, 0.25F));
  EXPECT_THAT(scan.ring, ElementsAre(7, 8));
  EXPECT_THAT(InputErrorOf([&] { ParseBinPoints(DataOf(file), 47, layout, "a.bin"); }),
              StartsWith("a.bin: 47 bytes are no whole number of 6 float32"));
  EXPECT_EQ(ParseBinPoints(nullptr, 0, layout, "a.bin").scan.size(), 0U);
}

TEST(BinPoints, RecognisesFiles) {
  const TempFolder folder;
  const std::string path = folder.Write(
      "1.bin", FileOf(Room([](int ring, double share) { return Record{Intensity(ring, share)}; })));
  const BinLayout layout = RecogniseBinFiles({folder / "0.bin", path});
  EXPECT_EQ(layout.note, "records of 4 floats: x y z intensity");
  EXPECT_EQ(ReadBinScan(path, layout).scan.size(), 16U * 90U);
  EXPECT_THAT(InputErrorOf([&] { RecogniseBinFiles({folder / "0.bin"}); }),
              StartsWith(folder / "0.bin"));
}

}  // namespace
}  // namespace tvl

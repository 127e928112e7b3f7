#include "tvl/io/cloud/las.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tvl/io/cloud/test_bytes.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr std::array<uint16_t, 11> kRecordBytes = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};

// Writes `value` over the bytes at `at`.
template <typename T>
void Put(std::string* file, size_t at, T value) {
  file->replace(at, sizeof(T), Bytes(value));
}

struct File {
  int minor = 2, format = 1;
  size_t points = 2;
  double scale_m = 0.001;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  int32_t first = 1000;  // x of the first point; the others follow at 1000 each

  std::string Text() const {
    const size_t header_bytes = minor <= 2 ? 227 : minor == 3 ? 235 : 375;
    const uint16_t record_bytes = kRecordBytes[static_cast<size_t>(format)];
    std::string file(header_bytes + 2, '\0');  // two bytes of user data before the points
    file.replace(0, 4, "LASF");
    file[24] = 1, file[25] = static_cast<char>(minor), file[104] = static_cast<char>(format);
    Put(&file, 94, static_cast<uint16_t>(header_bytes));
    Put(&file, 96, static_cast<uint32_t>(header_bytes + 2));
    Put(&file, 105, record_bytes);
    if (minor < 4) Put(&file, 107, static_cast<uint32_t>(points));
    if (minor == 4) Put(&file, 247, static_cast<uint64_t>(points));
    for (size_t axis = 0; axis < 3; ++axis) {
      Put(&file, 131 + 8 * axis, scale_m);
      Put(&file, 155 + 8 * axis, offset_m[static_cast<Eigen::Index>(axis)]);
    }
    for (size_t i = 0; i < points; ++i) {
      std::string record(record_bytes, '\0');
      Put(&record, 0, first + static_cast<int32_t>(1000 * i));
      Put(&record, 4, int32_t{-2000});
      Put(&record, 8, int32_t{3});
      Put(&record, 12, static_cast<uint16_t>(60000 + i));
      const bool has_time = format != 0 && format != 2;
      if (has_time) Put(&record, format < 6 ? 20 : 22, 0.5 + static_cast<double>(i));
      file += record;
    }
    return file;
  }
};

CloudRead Parse(const std::string& file) { return ParseLas(DataOf(file), file.size(), "a.las"); }

std::string ErrorOf(const std::string& file) {
  return InputErrorOf([&] { Parse(file); });
}

TEST(Las, ReadsEveryPointFormat) {
  for (int format = 0; format <= 10; ++format) {
    File file;
    file.format = format;
    file.minor = format < 6 ? 2 : 4;
    const CloudRead read = Parse(file.Text());
    ASSERT_EQ(read.scan.size(), 2U) << format;
    EXPECT_TRUE(read.scan.points[1].isApprox(Eigen::Vector3f(2.0F, -2.0F, 0.003F))) << format;
    EXPECT_THAT(read.scan.intensity, ElementsAre(60000.0F, 60001.0F)) << format;
    if (format == 0 || format == 2) {
      EXPECT_THAT(read.scan.time, IsEmpty()) << format;
    } else {
      EXPECT_THAT(read.scan.time, ElementsAre(0.5, 1.5)) << format;
    }
    EXPECT_THAT(read.notes, IsEmpty()) << format;
    EXPECT_EQ(read.scan.width, 2U);
  }
}

TEST(Las, ReadsEveryVersion) {
  for (int minor = 0; minor <= 4; ++minor) {
    File file;
    file.minor = minor;
    EXPECT_EQ(Parse(file.Text()).scan.size(), 2U) << minor;
  }
}

TEST(Las, KeepsMillimetresOfLargeCoordinates) {
  File file;
  file.offset_m = {600000.0, 5300000.0, 400.0};
  const CloudRead by_offset = Parse(file.Text());
  EXPECT_TRUE(by_offset.scan.points[0].isApprox(Eigen::Vector3f(1.0F, -2.0F, 0.003F)));
  EXPECT_THAT(by_offset.notes,
              ElementsAre(HasSubstr("the header's offset (600000.000, 5300000.000, 400.000)")));
  file.first = 2000000000;
  const CloudRead by_point = Parse(file.Text());
  EXPECT_TRUE(by_point.scan.points[1].isApprox(Eigen::Vector3f(1.0F, 0.0F, 0.0F)));
  EXPECT_THAT(by_point.notes, ElementsAre(HasSubstr("the first point (2600000.000")));
}

TEST(Las, KeepsSmallCoordinatesWhatTheOffset) {
  File file;
  file.offset_m = {10.0, 20.0, 30.0};
  const CloudRead read = Parse(file.Text());
  EXPECT_TRUE(read.scan.points[0].isApprox(Eigen::Vector3f(11.0F, 18.0F, 30.003F)));
  EXPECT_THAT(read.notes, IsEmpty());
}

TEST(Las, RefusesLaz) {
  for (const char bit : {'\x80', '\x40'}) {
    std::string file = File().Text();
    file[104] = static_cast<char>(file[104] | bit);
    EXPECT_THAT(ErrorOf(file), HasSubstr("compressed (LAZ), which is not read: unpack"));
  }
}

// `value` written at byte `at` of a good file.
template <typename T>
std::string ErrorWith(size_t at, T value, int minor = 2) {
  File good;
  good.minor = minor;
  std::string file = good.Text();
  Put(&file, at, value);
  return ErrorOf(file);
}

TEST(Las, RefusesHeadersThatLie) {
  EXPECT_THAT(ErrorWith(107, uint32_t{4000000000}), StartsWith("a.las: 4000000000 points are"));
  EXPECT_THAT(ErrorWith(247, ~uint64_t{0}, 4), HasSubstr("cut off"));
  EXPECT_THAT(ErrorWith(96, uint32_t{4000000000}), StartsWith("a.las: byte 94: a header"));
  EXPECT_THAT(ErrorWith(96, uint32_t{10}), HasSubstr("byte 94"));
  EXPECT_THAT(ErrorWith(94, uint16_t{226}), HasSubstr("byte 94"));
  EXPECT_THAT(ErrorWith(94, uint16_t{65535}), HasSubstr("byte 94"));
  EXPECT_THAT(ErrorWith(105, uint16_t{27}), HasSubstr("byte 105: points of 27 bytes"));
  EXPECT_THAT(ErrorWith(105, uint16_t{0}), HasSubstr("byte 105"));
  EXPECT_THAT(ErrorWith(104, uint8_t{11}), HasSubstr("point format 11"));
  EXPECT_THAT(ErrorWith(25, uint8_t{5}), HasSubstr("version 1.5"));
  EXPECT_THAT(ErrorWith(25, uint8_t{4}), HasSubstr("byte 94"));  // too short for 1.4
  EXPECT_THAT(ErrorWith(24, uint8_t{2}), HasSubstr("version 2.2"));
  EXPECT_THAT(ErrorWith(131, 0.0), HasSubstr("scales"));
  EXPECT_THAT(ErrorWith(155, std::numeric_limits<double>::quiet_NaN()), HasSubstr("offsets"));
}

TEST(Las, RefusesWhatIsCutOff) {
  const std::string file = File().Text();
  for (size_t bytes = 0; bytes < file.size(); ++bytes) {
    EXPECT_THAT(ErrorOf(file.substr(0, bytes)), StartsWith("a.las: ")) << bytes;
  }
}

TEST(Las, LeavesOutTimesThatAreNoNumbers) {
  std::string file = File().Text();
  Put(&file, 229 + 20, std::numeric_limits<double>::infinity());
  const CloudRead read = Parse(file);
  EXPECT_THAT(read.scan.time, IsEmpty());
  EXPECT_EQ(read.scan.time_field, "");
}

TEST(Las, ReadsFilesAndNamesThem) {
  const TempFolder folder;
  EXPECT_EQ(ReadLasScan(folder.Write("1.las", File().Text())).scan.size(), 2U);
  EXPECT_THAT(InputErrorOf([&] { ReadLasScan(folder / "2.las"); }), StartsWith(folder / "2.las"));
}

}  // namespace
}  // namespace tvl

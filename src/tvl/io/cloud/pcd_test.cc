#include "tvl/io/cloud/pcd.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tvl/io/cloud/lzf.h"
#include "tvl/io/cloud/test_bytes.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

CloudRead Parse(const std::string& file) { return ParsePcd(DataOf(file), file.size(), "a.pcd"); }

std::string ErrorOf(const std::string& file) {
  return InputErrorOf([&] { Parse(file); });
}

// A header of float32 x y z for `points` points in one row.
std::string Header(const std::string& points, const std::string& data) {
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + points +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n";
}

TEST(Pcd, ReadsAscii) {
  const CloudRead read = Parse(
      "# .PCD v.7\nVERSION 0.7\nFIELDS x y z intensity ring timestamp\nSIZE 4 4 4 4 2 8\n"
      "TYPE F F F F U F\nCOUNT 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n"
      "1 -2.5 3e0 7 63 1317376000.25\nnan nan nan 0 1 1317376000.5\n");
  ASSERT_EQ(read.scan.size(), 2U);
  EXPECT_EQ(read.scan.points[0], Eigen::Vector3f(1.0F, -2.5F, 3.0F));
  EXPECT_TRUE(std::isnan(read.scan.points[1].x()));
  EXPECT_THAT(read.scan.intensity, ElementsAre(7.0F, 0.0F));
  EXPECT_THAT(read.scan.ring, ElementsAre(63, 1));
  EXPECT_THAT(read.scan.time, ElementsAre(1317376000.25, 1317376000.5));
  EXPECT_EQ(read.scan.time_field, "timestamp");
  EXPECT_TRUE(read.notes.empty());
}

TEST(Pcd, ReadsBinaryWithPaddingAndDescriptors) {
  const std::string record =
      Bytes(1.0F, 2.0F, 3.0F, uint32_t{9}) + Bytes(1.5F, 2.5F, uint8_t{42}, uint16_t{7});
  const CloudRead read = Parse(
      "VERSION .7\r\nFIELDS x y z _ d intensity ring\r\nSIZE 4 4 4 1 4 1 2\r\nTYPE F F F U F U "
      "U\r\n"
      "COUNT 1 1 1 4 2 1 1\r\nWIDTH 2\r\nHEIGHT 2\r\nPOINTS 4\r\nDATA binary\r\n" +
      record + record + record + record + "behind the points");
  ASSERT_EQ(read.scan.size(), 4U);
  EXPECT_EQ(read.scan.width, 2U);
  EXPECT_EQ(read.scan.height, 2U);
  EXPECT_EQ(read.scan.points[3], Eigen::Vector3f(1.0F, 2.0F, 3.0F));
  EXPECT_EQ(read.scan.intensity[3], 42.0F);
  EXPECT_EQ(read.scan.ring[3], 7);
}

TEST(Pcd, ReadsVersion05AndItsDefaults) {
  const CloudRead read = Parse("COLUMNS x y z\nPOINTS 1\nDATA binary\n" + Bytes(1.0F, 2.0F, 3.0F));
  ASSERT_EQ(read.scan.size(), 1U);
  EXPECT_EQ(read.scan.points[0], Eigen::Vector3f(1.0F, 2.0F, 3.0F));
}

TEST(Pcd, ReadsCompressedFieldAfterField) {
  // Literals of x x y y, then z z: one literal and a copy of it.
  const std::string packed = std::string("\x0f") + Bytes(1.0F, 2.0F, 3.0F, 4.0F) + "\x03" +
                             Bytes(5.0F) + std::string("\x40\x03", 2);
  const std::string file = Header("2", "binary_compressed") +
                           Bytes(static_cast<uint32_t>(packed.size()), uint32_t{24}) + packed;
  const CloudRead read = Parse(file);
  ASSERT_EQ(read.scan.size(), 2U);
  EXPECT_EQ(read.scan.points[0], Eigen::Vector3f(1.0F, 3.0F, 5.0F));
  EXPECT_EQ(read.scan.points[1], Eigen::Vector3f(2.0F, 4.0F, 5.0F));
  for (size_t cut = file.size() - 1; cut + 1 > file.size() - packed.size() - 8; --cut) {
    EXPECT_THAT(ErrorOf(file.substr(0, cut)), HasSubstr("cut off")) << cut;
  }
}

TEST(Pcd, NotesTheViewpoint) {
  const CloudRead read = Parse(
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT 1\n"
      "VIEWPOINT 1 2 3 1 0 0 0\nPOINTS 0\nDATA ascii\n");
  EXPECT_EQ(read.scan.size(), 0U);
  EXPECT_THAT(read.notes, ElementsAre(HasSubstr("VIEWPOINT 1 2 3 1 0 0 0")));
}

TEST(Pcd, RefusesHeadersThatLie) {
  const std::string point = Bytes(1.0F, 2.0F, 3.0F);
  EXPECT_THAT(ErrorOf(Header("4000000000", "binary") + std::string(1000, 'a')),
              StartsWith("a.pcd: byte 139: 4000000000 x 1 points"));
  EXPECT_THAT(ErrorOf(Header("-5", "binary") + point), StartsWith("a.pcd:9: POINTS: want a whole"));
  EXPECT_THAT(ErrorOf(Header("99999999999999999999999", "binary") + point), HasSubstr("POINTS"));
  EXPECT_THAT(ErrorOf(Header("1.5", "ascii")), HasSubstr("POINTS"));
  EXPECT_THAT(ErrorOf(Header("2", "binary") + point), HasSubstr("cut off"));
  EXPECT_THAT(ErrorOf(Header("4000000000", "ascii") + "1 2 3\n"), HasSubstr("cut off"));
  EXPECT_THAT(ErrorOf(Header("2", "ascii") + "1 2 3\n"), HasSubstr("1 points, the header says 2"));
  EXPECT_THAT(ErrorOf(Header("1", "ascii") + "1 2 3\n4 5 6\n"), HasSubstr("a.pcd:12: more points"));
  EXPECT_THAT(ErrorOf(Header("1", "ascii") + "1 2\n"), StartsWith("a.pcd:11: want 3 numbers"));
  EXPECT_THAT(ErrorOf(Header("1", "ascii") + "1 2 z\n"), StartsWith("a.pcd:11: not a number"));
  EXPECT_THAT(ErrorOf(Header("1", "zip") + point), StartsWith("a.pcd:10: DATA: want ascii"));
  EXPECT_THAT(ErrorOf("FIELDS x y z\nWIDTH 2\nHEIGHT 3\nPOINTS 7\nDATA binary\n"),
              HasSubstr("WIDTH 2 x HEIGHT 3 is not POINTS 7"));
  EXPECT_THAT(ErrorOf("FIELDS x y z\nWIDTH 4294967296\nHEIGHT 4294967296\nDATA binary\n"),
              HasSubstr("WIDTH 4294967296 x HEIGHT"));
  EXPECT_EQ(Parse("FIELDS x y z\nWIDTH 0\nHEIGHT 4000000000\nDATA binary\n").scan.size(), 0U);
}

TEST(Pcd, RefusesFieldsItCannotRead) {
  const auto error = [](const std::string& fields) {
    return ErrorOf(fields + "\nWIDTH 1\nHEIGHT 1\nDATA binary\n" + std::string(64, '\0'));
  };
  EXPECT_THAT(error("FIELDS x y z\nSIZE 4 4\nTYPE F F F"), StartsWith("a.pcd:2: SIZE: want one"));
  EXPECT_THAT(error("FIELDS x y z\nSIZE 4 4 3\nTYPE F F F"), HasSubstr("TYPE `F` of SIZE `3`"));
  EXPECT_THAT(error("FIELDS x y z\nSIZE 4 4 4\nTYPE F F X"), HasSubstr("TYPE `X` of SIZE `4`"));
  EXPECT_THAT(error("FIELDS x y z\nSIZE 4 4 -4\nTYPE F F F"), HasSubstr("SIZE `-4`"));
  EXPECT_THAT(error("FIELDS x y z\nCOUNT 1 1 0"), HasSubstr("COUNT: want 1 or more"));
  EXPECT_THAT(error("FIELDS x y z\nCOUNT 1 1 -1"), HasSubstr("COUNT: want a whole number"));
  EXPECT_THAT(error("FIELDS x y z\nCOUNT 1 1 4000000000"), HasSubstr("COUNT: want a whole number"));
  EXPECT_THAT(error("FIELDS x y z\nCOUNT 1 1 65536"), HasSubstr("cut off"));
  EXPECT_THAT(error("FIELDS x y"), HasSubstr("no fields x, y and z"));
  EXPECT_THAT(error("FIELDS"), HasSubstr("no FIELDS"));
  EXPECT_THAT(error("SIZE 4 4 4"), HasSubstr("no FIELDS"));
  EXPECT_THAT(error("FIELDS x y z\nFIELDS x y z"), StartsWith("a.pcd:2: FIELDS is there twice"));
  EXPECT_THAT(error("FIELDS x y z\nVIEWPOINT 1 2"), HasSubstr("want 7 numbers"));
}

TEST(Pcd, RefusesWhatIsNoPcd) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("not a PCD file"));
  EXPECT_THAT(ErrorOf("\x89PNG\r\n\x1a\n"), HasSubstr("not a PCD file"));
  EXPECT_THAT(ErrorOf("VERSION 0.7\nFIELDS x y z\n"), HasSubstr("ends without DATA"));
  EXPECT_THAT(ErrorOf("FIELDS x y z\nDATA ascii\n"), HasSubstr("neither POINTS nor WIDTH"));
  EXPECT_THAT(ErrorOf("FIELDS x y z\nPOINTS 1\nDATA\n"), HasSubstr("DATA: want"));
  std::string comments;
  for (int i = 0; i < 2000; ++i) comments += "# a\n";
  EXPECT_THAT(ErrorOf(comments), HasSubstr("not a PCD file"));
}

TEST(Pcd, RefusesCompressedSizesThatLie) {
  const auto error = [](uint32_t points, uint32_t packed_bytes, uint32_t unpacked_bytes,
                        const std::string& packed) {
    return ErrorOf(Header(std::to_string(points), "binary_compressed") +
                   Bytes(packed_bytes, unpacked_bytes) + packed);
  };
  const std::string some(100, '\0');
  EXPECT_THAT(error(1, 4000000000U, 12, some), HasSubstr("4000000000 compressed bytes"));
  EXPECT_THAT(error(1, 100, 24, some), HasSubstr("24 bytes are announced for 1 points"));
  EXPECT_THAT(error(10000000, 100, 120000000, some), HasSubstr("cannot hold"));
  EXPECT_THAT(error(4000000000U, 100, 3758096384U, some), HasSubstr("are announced for"));
  EXPECT_THAT(error(1, 0, 12, ""), HasSubstr("the data end too early"));
  EXPECT_THAT(error(1, 3, 12, std::string("\x20\x00\x00", 3)), HasSubstr("before the beginning"));
}

TEST(Pcd, ReadsFilesAndNamesThem) {
  const TempFolder folder;
  const std::string path = folder.Write("1.pcd", Header("1", "ascii") + "1 2 3\n");
  EXPECT_EQ(ReadPcdScan(path).scan.size(), 1U);
  for (const std::string& bad : {folder / "2.pcd", folder.path().string()}) {
    EXPECT_THAT(InputErrorOf([&] { ReadPcdScan(bad); }), StartsWith(bad));
  }
}

std::string Unpacked(const std::string& packed, size_t bytes) {
  const std::vector<uint8_t> out = UnpackLzf(DataOf(packed), packed.size(), bytes, "a");
  return {out.begin(), out.end()};
}

TEST(Lzf, UnpacksLiteralsCopiesAndRuns) {
  EXPECT_EQ(Unpacked("\x02"
                     "abc",
                     3),
            "abc");
  EXPECT_EQ(Unpacked(std::string("\x02"
                                 "abc"
                                 "\x20\x02",
                                 6),
                     6),
            "abcabc");
  EXPECT_EQ(Unpacked(std::string("\x00"
                                 "a"
                                 "\xe0\x05\x00",
                                 5),
                     15),
            std::string(15, 'a'));
  EXPECT_EQ(Unpacked("", 0), "");
}

TEST(Lzf, RefusesWhatDoesNotUnpack) {
  const auto error = [](const std::string& packed, size_t bytes) {
    return InputErrorOf([&] { Unpacked(packed, bytes); });
  };
  EXPECT_THAT(error("\x05"
                    "abc",
                    6),
              HasSubstr("break off"));
  EXPECT_THAT(error("\x02"
                    "abc",
                    2),
              HasSubstr("more data than announced"));
  EXPECT_THAT(error("\x02"
                    "abc",
                    4),
              HasSubstr("end too early"));
  EXPECT_THAT(error(std::string("\x00"
                                "a"
                                "\x20\x01",
                                4),
                    4),
              HasSubstr("before the beginning"));
  EXPECT_THAT(error(std::string("\x00"
                                "a"
                                "\x20",
                                3),
                    4),
              HasSubstr("break off"));
  EXPECT_THAT(error(std::string("\x00"
                                "a"
                                "\xe0\xff\x00",
                                5),
                    100),
              HasSubstr("more data"));
  EXPECT_THAT(error("\x00"
                    "a",
                    size_t{1} << 40),
              HasSubstr("cannot hold"));
}

}  // namespace
}  // namespace tvl

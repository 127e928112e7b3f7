#include "tvl/io/cloud/ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/io/cloud/test_bytes.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

CloudRead Parse(const std::string& file) { return ParsePly(DataOf(file), file.size(), "a.ply"); }

std::string ErrorOf(const std::string& file) {
  return InputErrorOf([&] { Parse(file); });
}

constexpr char kXyz[] = "property float x\nproperty float y\nproperty float z\n";

std::string Header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\ncomment by nobody\n" + elements + "end_header\n";
}

TEST(Ply, ReadsAsciiBetweenOtherElements) {
  const CloudRead read = Parse(Header("ascii",
                                      "element camera 2\nproperty list uchar int views\n"
                                      "element vertex 2\nproperty double x\nproperty list uchar "
                                      "int tags\nproperty float y\nproperty float z\nproperty "
                                      "uchar scalar_intensity\nelement face 1\nproperty list "
                                      "uchar int vertex_indices\n") +
                               "3 1 2 3\n0\n1 2 8 9 -2 3 200\n4 0 nan 6 7\n3 0 1 1\n");
  ASSERT_EQ(read.scan.size(), 2U);
  EXPECT_EQ(read.scan.points[0], Eigen::Vector3f(1.0F, -2.0F, 3.0F));
  EXPECT_EQ(read.scan.points[1].z(), 6.0F);
  EXPECT_THAT(read.scan.intensity, ElementsAre(200.0F, 7.0F));
}

TEST(Ply, ReadsBinaryOfBothOrders) {
  const std::string elements =
      "element vertex 1\nproperty float x\nproperty double y\nproperty short z\n"
      "property ushort ring\nproperty uint t\n";
  const CloudRead little = Parse(Header("binary_little_endian", elements) +
                                 Bytes(1.0F, 2.0, int16_t{-3}, uint16_t{5}, uint32_t{99}));
  const CloudRead big =
      Parse(Header("binary_big_endian", elements) + BigBytes(1.0F) + BigBytes(2.0) +
            BigBytes(int16_t{-3}) + BigBytes(uint16_t{5}) + BigBytes(uint32_t{99}));
  for (const CloudRead* read : {&little, &big}) {
    ASSERT_EQ(read->scan.size(), 1U);
    EXPECT_EQ(read->scan.points[0], Eigen::Vector3f(1.0F, 2.0F, -3.0F));
    EXPECT_THAT(read->scan.ring, ElementsAre(5));
    EXPECT_THAT(read->scan.time, ElementsAre(99.0));
  }
}

TEST(Ply, SkipsBinaryListsBeforeAndWithinVertices) {
  const CloudRead read = Parse(
      Header("binary_little_endian",
             "element face 2\nproperty list uchar int i\nproperty uchar flag\nelement pose 1\n"
             "property float a\nelement vertex 2\nproperty float x\nproperty list ushort double d\n"
             "property float y\nproperty float z\n") +
      Bytes(uint8_t{1}, int32_t{7}, uint8_t{0}) + Bytes(uint8_t{0}, uint8_t{0}) + Bytes(0.5F) +
      Bytes(1.0F, uint16_t{1}, 9.0, 2.0F, 3.0F) + Bytes(4.0F, uint16_t{0}, 5.0F, 6.0F));
  ASSERT_EQ(read.scan.size(), 2U);
  EXPECT_EQ(read.scan.points[0], Eigen::Vector3f(1.0F, 2.0F, 3.0F));
  EXPECT_EQ(read.scan.points[1], Eigen::Vector3f(4.0F, 5.0F, 6.0F));
}

TEST(Ply, RefusesHeadersThatLie) {
  const auto vertices = [](const std::string& count) {
    return "element vertex " + count + "\n" + kXyz;
  };
  const std::string little = "binary_little_endian";
  EXPECT_THAT(ErrorOf(Header(little, vertices("4000000000")) + std::string(1000, 'a')),
              StartsWith("a.ply: byte 142: 4000000000 x 1 points"));
  EXPECT_THAT(ErrorOf(Header("ascii", vertices("4000000000")) + "1 2 3\n"),
              HasSubstr("ends after 1 of 4000000000 lines"));
  EXPECT_THAT(ErrorOf(Header(little, vertices("-1"))), StartsWith("a.ply:4: want a whole number"));
  EXPECT_THAT(ErrorOf(Header(little, vertices("2")) + Bytes(1.0F, 2.0F, 3.0F)),
              HasSubstr("cut off"));
  const std::string before = "element face 4000000000\nproperty list uchar int i\n";
  EXPECT_THAT(ErrorOf(Header(little, before + vertices("1")) + std::string(1000, '\0')),
              HasSubstr("cut off"));
  const std::string plain = "element face 4000000000\nproperty double i\n";
  EXPECT_THAT(ErrorOf(Header(little, plain + vertices("1")) + std::string(1000, '\0')),
              HasSubstr("cut off"));
  EXPECT_THAT(ErrorOf(Header(little, "element face 4000000000\n" + vertices("1"))),
              HasSubstr("has no properties"));
  EXPECT_THAT(ErrorOf(Header("ascii", vertices("1")) + "1 2\n"), HasSubstr("only 2 numbers"));
  EXPECT_THAT(ErrorOf(Header("ascii", vertices("1")) + "1 2 3 4\n"), HasSubstr("want 3 numbers"));
}

TEST(Ply, RefusesListsThatLie) {
  const auto error = [](const std::string& type, const std::string& data) {
    return ErrorOf(Header("binary_little_endian", "element face 1\nproperty list " + type +
                                                      " double i\nelement vertex 1\n" + kXyz) +
                   data);
  };
  EXPECT_THAT(error("int", Bytes(int32_t{-1})), HasSubstr("list of length -1"));
  EXPECT_THAT(error("uint", Bytes(uint32_t{4000000000})), HasSubstr("list of length 4e+09"));
  EXPECT_THAT(error("uint64", Bytes(~uint64_t{0})), HasSubstr("cut off"));
  EXPECT_THAT(error("uchar", Bytes(uint8_t{8}, 1.0)), HasSubstr("8 times 8 bytes"));
  EXPECT_THAT(error("float", Bytes(1.0F)), HasSubstr("must be a whole number"));
  const std::string ascii =
      Header("ascii", "element vertex 1\nproperty list int int i\n" + std::string(kXyz));
  EXPECT_THAT(ErrorOf(ascii + "9 1 2 3\n"), HasSubstr("length of a list: want a whole number"));
  EXPECT_THAT(ErrorOf(ascii + "-1 1 2 3\n"), HasSubstr("length of a list: want a whole number"));
}

TEST(Ply, RefusesWhatIsNoPly) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("not a PLY file"));
  EXPECT_THAT(ErrorOf("plyx\n"), HasSubstr("not a PLY file"));
  EXPECT_THAT(ErrorOf("ply\nformat ascii 1.0\n"), HasSubstr("does not end"));
  EXPECT_THAT(ErrorOf("ply\nend_header\n"), HasSubstr("no format"));
  EXPECT_THAT(ErrorOf("ply\nformat zip 1.0\nend_header\n"), StartsWith("a.ply:2: want `format"));
  EXPECT_THAT(ErrorOf("ply\nformat ascii 1.0\nend_header\n"), HasSubstr("no element vertex"));
  EXPECT_THAT(ErrorOf("ply\nproperty float x\n"), HasSubstr("before any element"));
  EXPECT_THAT(ErrorOf("ply\nelement vertex 1\nproperty half x\n"), HasSubstr("`half`"));
  EXPECT_THAT(ErrorOf("ply\nelement vertex 1\nproperty x\n"), HasSubstr("want `property TYPE"));
  EXPECT_THAT(ErrorOf("ply\nelement vertex\n"), HasSubstr("want `element NAME COUNT`"));
  EXPECT_THAT(ErrorOf("ply\nweather fine\n"), HasSubstr("unknown key `weather`"));
  EXPECT_THAT(ErrorOf(Header("ascii", "element vertex 1\nproperty float x\n") + "1\n"),
              HasSubstr("no fields x, y and z"));
}

TEST(Ply, ReadsFilesAndNamesThem) {
  const TempFolder folder;
  const std::string path =
      folder.Write("1.ply", Header("ascii", std::string("element vertex 1\n") + kXyz) + "1 2 3\n");
  EXPECT_EQ(ReadPlyScan(path).scan.size(), 1U);
  EXPECT_THAT(InputErrorOf([&] { ReadPlyScan(folder / "2.ply"); }), StartsWith(folder / "2.ply"));
}

}  // namespace
}  // namespace tvl

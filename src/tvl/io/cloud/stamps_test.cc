#include "tvl/io/cloud/stamps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

std::vector<int64_t> NanosecondsOf(const StampsRead& read) {
  std::vector<int64_t> ns;
  for (const Timestamp stamp : read.stamps) ns.push_back(stamp.ns);
  return ns;
}

TEST(Stamps, TellsUnitsByDateAndRate) {
  struct Case {
    std::vector<std::string> words;
    std::string what;
    int64_t second_ns;
  };
  const std::vector<Case> cases = {
      {{"0.0", "0.1", "0.2"}, "seconds, 10 Hz", 100000000},
      {{"0", "50", "100"}, "milliseconds, 20 Hz", 50000000},
      {{"7", "100007", "200007"}, "microseconds, 10 Hz", 100007000},
      {{"5", "50000005", "100000005"}, "nanoseconds, 20 Hz", 50000005},
      {{"1317376000.123456789", "1317376000.223456788"},
       "seconds since 1970, 10 Hz",
       1317376000223456788},
      {{"1.317376000123456789e+09", "1.317376000223456788e+09"},
       "seconds since 1970, 10 Hz",
       1317376000223456788},
      {{"1317376000123", "1317376000223"}, "milliseconds since 1970, 10 Hz", 1317376000223000000},
      {{"1532402927647951", "1532402927698048"}, "microseconds since 1970", 1532402927698048000},
      {{"1317376000123456789", "1317376000223456788"},
       "nanoseconds since 1970, 10 Hz",
       1317376000223456788}};
  for (const Case& one : cases) {
    const StampsRead read = StampsOfNumbers(one.words, "a");
    ASSERT_EQ(read.stamps.size(), one.words.size()) << one.what << read.what;
    EXPECT_EQ(read.stamps[1].ns, one.second_ns) << one.what;
    EXPECT_THAT(read.what, StartsWith(one.what));
    EXPECT_EQ(read.is_since_1970, one.what.find("1970") != std::string::npos);
  }
}

TEST(Stamps, SaysWhatIsDoubtful) {
  // Every 3 s: no lidar turns that slowly, but the date tells the unit.
  EXPECT_THAT(StampsOfNumbers({"1317376000", "1317376003"}, "a").what,
              HasSubstr("rate is unusual"));
  // 1.3 s after the start in ns, or 2011 in s with steps of three years.
  const StampsRead doubtful = StampsOfNumbers({"1317376000", "1417376000"}, "a");
  EXPECT_THAT(doubtful.what, HasSubstr("doubtful"));
  EXPECT_TRUE(doubtful.is_doubtful);
  EXPECT_THAT(NanosecondsOf(doubtful), ElementsAre(1317376000, 1417376000));
}

TEST(Stamps, RefusesWhatIsNoTime) {
  EXPECT_THAT(StampsOfNumbers({"0", "1", "2", "3"}, "a").stamps, IsEmpty());
  EXPECT_THAT(StampsOfNumbers({"3", "2", "1"}, "a").what, HasSubstr("do not increase"));
  EXPECT_THAT(StampsOfNumbers({"0", "5", "10"}, "a").what, HasSubstr("in no unit"));
  EXPECT_THAT(StampsOfNumbers({"0.5"}, "a").stamps, IsEmpty());
  EXPECT_THAT(StampsOfNumbers({}, "a").stamps, IsEmpty());
  EXPECT_EQ(StampsOfNumbers({"1317376000"}, "a").stamps.size(), 1U);
  EXPECT_THROW(StampsOfNumbers({"1", "x"}, "a"), InputError);
}

TEST(Stamps, OneStepBackDoesNotCount) {
  std::vector<std::string> words;
  for (int i = 0; i < 30; ++i) words.push_back(std::to_string(0.1 * i));
  words[20] = "0.5";
  EXPECT_EQ(StampsOfNumbers(words, "a").stamps.size(), 30U);
}

TEST(Stamps, ReadsTextFiles) {
  const TempFolder folder;
  const auto read = [&](const std::string& text) {
    return ReadStampFile(folder.Write("times.txt", text));
  };
  EXPECT_THAT(NanosecondsOf(read("# seconds\n\n0.5\r\n0.6\r\n")),
              ElementsAre(500000000, 600000000));
  EXPECT_THAT(NanosecondsOf(read("index,stamp,name\n0,1317376000123456789,a.pcd\n"
                                 "1,1317376000223456789,b.pcd\n")),
              ElementsAre(1317376000123456789, 1317376000223456789));
  EXPECT_THAT(NanosecondsOf(read("#timestamp [ns],filename\n1403636579763555584,x.png\n"
                                 "1403636579813555456,y.png\n")),
              ElementsAre(1403636579763555584, 1403636579813555456));
  EXPECT_THAT(NanosecondsOf(read("2011-09-26 13:02:25.964389445\n2011-09-26 13:02:26.067691000\n")),
              ElementsAre(1317042145964389445, 1317042146067691000));
  EXPECT_THAT(read("0.5\n0.6 7\nx\n").what, HasSubstr("no numbers"));
  EXPECT_THAT(read("2011-09-26 13:02:25.9\nnext\n").what, HasSubstr("times.txt:2"));
  EXPECT_THAT(read("").stamps, IsEmpty());
  EXPECT_THAT(read(std::string("\0\1\2\n", 4)).stamps, IsEmpty());
  EXPECT_THAT(ReadStampFile(folder / "none.txt").stamps, IsEmpty());
  EXPECT_THAT(ReadStampFile(folder.path().string()).stamps, IsEmpty());
}

TEST(Stamps, BelongToFilesByPositionOrNumber) {
  const TempFolder folder;
  const std::string times = folder.Write("times.txt", "0.0\n0.1\n0.2\n0.3\n");
  EXPECT_THAT(NanosecondsOf(StampsFromFile(times, {"a", "b", "c", "d"})),
              ElementsAre(0, 100000000, 200000000, 300000000));
  EXPECT_THAT(NanosecondsOf(StampsFromFile(times, {"001.bin", "003.bin"})),
              ElementsAre(100000000, 300000000));
  EXPECT_THAT(StampsFromFile(times, {"001.bin", "004.bin"}).what, HasSubstr("4 stamps for 2"));
  // A table of another sensor has lines for every number.
  const std::string imu = folder.Write("imu.csv", "0.0\n0.1\n0.2\n0.3\n");
  EXPECT_THAT(StampsFromFile(imu, {"001.bin", "003.bin"}).stamps, IsEmpty());
}

TEST(Stamps, AreNamesOnlyWhereTheseAreTimes) {
  EXPECT_THAT(
      NanosecondsOf(StampsFromNames({"1317376000123456789.bin", "1317376000223456788.bin"})),
      ElementsAre(1317376000123456789, 1317376000223456788));
  EXPECT_THAT(
      NanosecondsOf(StampsFromNames({"c_1317376000_000000001.pcd", "c_1317376000_100000001.pcd"})),
      ElementsAre(1317376000000000001, 1317376000100000001));
  EXPECT_THAT(NanosecondsOf(StampsFromNames({"0.100.pcd", "0.201.pcd", "0.299.pcd"})),
              ElementsAre(100000000, 201000000, 299000000));
  EXPECT_THAT(StampsFromNames({"000000.bin", "000001.bin", "000002.bin"}).stamps, IsEmpty());
  EXPECT_THAT(StampsFromNames({"000000.bin", "000010.bin", "000020.bin"}).what,
              HasSubstr("frame numbers"));
  EXPECT_THAT(StampsFromNames({"a.bin", "b.bin"}).stamps, IsEmpty());
  EXPECT_THAT(StampsFromNames({"a_0.1.bin", "b_0.2.bin", "b_0.31.bin"}).stamps, IsEmpty());
  EXPECT_THAT(StampsFromNames({std::string(400, '9') + ".bin"}).stamps, IsEmpty());
}

}  // namespace
}  // namespace tvl

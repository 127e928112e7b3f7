#include "tvl/io/ros/bag_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/io/ros/test_bags.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int64_t kFirst_ns = 1'600'000'000'100'000'000;  // as tests/data/make_bags.py has it
constexpr int64_t kStep_ns = 100'000'000;

std::string TextOfError(const std::string& path, const BagOptions& options) {
  try {
    OpenBag(path, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

// Scan k of tests/data/make_bags.py.
void ExpectScan(const RawScanRead& read, int k) {
  ASSERT_NE(read.scan, nullptr) << read.faults.at(0).message;
  ASSERT_EQ(read.scan->size(), 12U);
  for (size_t i = 0; i < 12; ++i) {
    const auto f = static_cast<float>(i);
    EXPECT_EQ(read.scan->points[i],
              Eigen::Vector3f(static_cast<float>(k) + f / 4, -f, static_cast<float>(k) / 2));
    EXPECT_EQ(read.scan->intensity[i], f);
    EXPECT_EQ(read.scan->ring[i], i % 4);
  }
}

void ExpectScans(const Recording& recording, size_t count) {
  ASSERT_EQ(recording.scans->size(), count);
  for (size_t k = 0; k < count; ++k) {
    const auto n = static_cast<int64_t>(k);
    EXPECT_EQ(recording.scans->Stamp(k)->ns, kFirst_ns + n * kStep_ns);
    ExpectScan(recording.scans->Read(k), static_cast<int>(k));
  }
}

class EveryFormat : public testing::TestWithParam<const char*> {};

TEST_P(EveryFormat, DeliversWhatWasWritten) {
  for (const std::string topic : {"/cam/image_raw", "/cam/image_raw/compressed"}) {
    EXPECT_TRUE(LooksLikeBag(BagPath(GetParam())));
    const Recording recording = OpenBag(BagPath(GetParam()), {"", topic});
    ExpectScans(recording, 3);
    ASSERT_EQ(recording.images->size(), 3U);
    for (size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(recording.images->Stamp(k), recording.scans->Stamp(k));
      const cv::Mat image = recording.images->Read(k).image;
      ASSERT_EQ(image.size(), cv::Size(16, 8));
      EXPECT_EQ(image.at<cv::Vec3b>(7, 15),
                cv::Vec3b(static_cast<uint8_t>(10 * (k + 1)), 100, 200));
    }
    ASSERT_TRUE(recording.camera.has_value());
    EXPECT_EQ(recording.camera->fy_px, 21.0);
    EXPECT_EQ(recording.camera->distortion[0], -0.1);
    Matrix34d T_cam_lidar;
    T_cam_lidar << 0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, -1;
    ASSERT_TRUE(recording.T_cam_lidar.has_value());
    EXPECT_LT((recording.T_cam_lidar->Matrix() - T_cam_lidar).norm(), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Bags, EveryFormat,
                         testing::Values("ros1_none.bag", "ros1_bz2.bag", "ros1_lz4.bag", "sqlite",
                                         "sqlite/sqlite.db3", "none.mcap", "zstd.mcap", "lz4.mcap",
                                         "ros1.mcap", "unchunked.mcap", "unindexed.mcap",
                                         "split_mcap", "split_sqlite"));

TEST(BagRecording, ReadsLivoxMessages) {
  for (const char* name : {"livox_ros1.bag", "livox_ros2.mcap"}) {
    const Recording recording = OpenBag(BagPath(name), {});
    ExpectScans(recording, 2);
    if (HasFailure()) return;  // there may be no scan
    EXPECT_EQ(recording.scans->Read(0).scan->time_field, "offset_time");
    EXPECT_EQ(recording.scans->Read(0).scan->time[3], 3000.0);
    EXPECT_EQ(recording.images, nullptr);
  }
}

TEST(BagRecording, TheRawImageTopicIsTakenAndWhatIsRecognisedIsSaid) {
  const Recording recording = OpenBag(BagPath("ros1_lz4.bag"), {});
  EXPECT_THAT(recording.warnings, IsEmpty());
  EXPECT_THAT(recording.notes, Contains(HasSubstr("lz4")));
  EXPECT_THAT(recording.notes, Contains(HasSubstr("images: /cam/image_raw (")));
  EXPECT_THAT(recording.notes, Contains(HasSubstr("x float32, y float32")));
}

TEST(BagRecording, AnotherClockGivesWayToTheTimesOfRecording) {
  const Recording recording = OpenBag(BagPath("own_clock.mcap"), {});
  EXPECT_THAT(recording.warnings, Contains(HasSubstr("different clocks")));
  EXPECT_EQ(recording.scans->Stamp(1)->ns, kFirst_ns + kStep_ns);
  EXPECT_EQ(recording.images->Stamp(1)->ns, kFirst_ns + kStep_ns + 1'000'000);
  EXPECT_EQ(recording.camera->distortion_model, DistortionModel::kEquidistant);
  EXPECT_THAT(recording.warnings, Contains(HasSubstr("comes from /tf")));
  EXPECT_EQ(recording.T_cam_lidar->t(), Eigen::Vector3d(-1, 0, 0));
}

TEST(BagRecording, WhatIsMissingIsSaid) {
  const Recording recording = OpenBag(BagPath("no_stamps.mcap"), {});
  ExpectScans(recording, 2);  // by the time of recording
  EXPECT_THAT(recording.warnings, Contains(HasSubstr("2 of 2 messages have no stamp")));
  EXPECT_FALSE(recording.camera.has_value());
  EXPECT_THAT(recording.warnings,
              Contains(HasSubstr("is of images of 32x16, the images are 16x8")));
  EXPECT_FALSE(recording.T_cam_lidar.has_value());
  EXPECT_THAT(recording.warnings, Contains(HasSubstr("no transforms")));
  EXPECT_FALSE(recording.images->Read(0).image.empty());
}

TEST(BagRecording, TopicsThatAreNotThereAreNamed) {
  EXPECT_THAT(TextOfError(BagPath("none.mcap"), {"/nowhere", ""}), HasSubstr("/points"));
  EXPECT_THAT(TextOfError(BagPath("none.mcap"), {"", "/points"}), HasSubstr("/cam/image_raw"));
  EXPECT_THAT(TextOfError(BagPath("livox_ros1.bag"), {"", "/cam"}), HasSubstr("--image-topic"));
}

// Writing over a file would wait for the disk.
std::string WriteAnew(const TempFolder& folder, const std::string& name, const std::string& text) {
  std::filesystem::remove(folder / name);
  return folder.Write(name, text);
}

// However much of a bag is cut off: what is left of it is delivered, in order, with a warning.
void ExpectStartSurvives(const std::string& name) {
  const TempFolder folder;
  const std::string whole = ReadBytesOf(BagPath(name));
  size_t most = 0;
  for (size_t bytes = 0; bytes < whole.size(); bytes += 1 + bytes / 40) {
    const std::string path = WriteAnew(folder, "cut" + name, whole.substr(0, bytes));
    try {
      const Recording recording = OpenBag(path, {});
      EXPECT_THAT(recording.warnings, testing::Not(IsEmpty())) << bytes;
      most = std::max(most, recording.scans->size());
      for (size_t k = 0; k < recording.scans->size(); ++k) {
        EXPECT_NE(recording.scans->Read(k).scan, nullptr) << name << " " << bytes;
      }
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("cut" + name));
    }
  }
  EXPECT_EQ(most, 3U);
}

TEST(BagRecording, CutOffBagsGiveWhatIsLeft) {
  for (const char* name : {"ros1_none.bag", "ros1_bz2.bag", "ros1_lz4.bag", "none.mcap",
                           "zstd.mcap", "lz4.mcap", "unchunked.mcap", "unindexed.mcap"}) {
    ExpectStartSurvives(name);
  }
}

TEST(BagRecording, TheBreakIsNamedByItsByte) {
  const TempFolder folder;
  const std::string whole = ReadBytesOf(BagPath("ros1_none.bag"));
  const std::string path = folder.Write("cut.bag", whole.substr(0, 7000));
  EXPECT_THAT(OpenBag(path, {}).warnings, Contains(HasSubstr("byte ")));
}

TEST(BagRecording, CutOffDatabasesGiveWhatIsLeft) {
  const TempFolder folder;
  const std::string whole = ReadBytesOf(BagPath("sqlite/sqlite.db3"));
  for (size_t bytes = 16; bytes < whole.size(); bytes += 1000) {
    const std::string path = WriteAnew(folder, "cut.db3", whole.substr(0, bytes));
    try {
      const Recording recording = OpenBag(path, {});
      EXPECT_THAT(recording.warnings, testing::Not(IsEmpty())) << bytes;
      for (size_t k = 0; k < recording.scans->size(); ++k) recording.scans->Read(k);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("cut.db3"));
    }
  }
}

// Bytes of the file are changed in turn: errors, warnings and faults are all right.
void ExpectDamageIsHarmless(const std::string& name, size_t step) {
  const std::string whole = ReadBytesOf(BagPath(name));
  const TempFolder folder;
  for (size_t at = 0; at < whole.size(); at += step) {
    for (const char value : {'\xFF', '\x00', '\x7F'}) {
      std::string damaged = whole;
      damaged[at] = value;
      const std::string path = WriteAnew(folder, "damaged", damaged);
      try {
        const Recording recording = OpenBag(path, {});
        for (size_t k = 0; k < recording.scans->size(); ++k) recording.scans->Read(k);
        for (size_t k = 0; recording.images && k < recording.images->size(); ++k) {
          recording.images->Read(k);
        }
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("damaged"));
      }
    }
  }
}

TEST(BagRecording, DamagedBytesAreErrorsOrFaults) {
  for (const char* name : {"ros1_lz4.bag", "zstd.mcap", "none.mcap"}) {
    ExpectDamageIsHarmless(name, 23);  // every so many bytes: in about a second
  }
  ExpectDamageIsHarmless("sqlite/sqlite.db3", 211);
}

TEST(BagRecording, MetadataMayNotLeaveItsFolder) {
  const TempFolder folder;
  for (const char* name : {"../outside.mcap", "/outside.mcap", "a/../../outside.mcap", "''"}) {
    folder.Write(
        "metadata.yaml",
        std::string("rosbag2_bagfile_information:\n  relative_file_paths: [") + name + "]\n");
    EXPECT_THAT(TextOfError(folder.path().string(), {}), HasSubstr("leaves the folder")) << name;
  }
  folder.Write("metadata.yaml", "rosbag2_bagfile_information: [");
  EXPECT_THAT(TextOfError(folder.path().string(), {}), HasSubstr("metadata.yaml"));
  EXPECT_FALSE(LooksLikeBag(folder.path().string()));
  folder.Write("metadata.yaml", "rosbag2_bagfile_information:\n  compression_mode: FILE\n");
  EXPECT_THAT(TextOfError(folder.path().string(), {}), HasSubstr("compressed by FILE"));
}

TEST(BagRecording, MissingPartsAreWarnedOf) {
  const TempFolder folder;
  std::filesystem::copy(BagPath("split_mcap"), folder.path());
  std::filesystem::remove(folder / "split_mcap_2.mcap");
  const Recording recording = OpenBag(folder.path().string(), {});
  EXPECT_THAT(recording.warnings, Contains(HasSubstr("split_mcap_2.mcap")));
  EXPECT_GE(recording.scans->size(), 1U);
  std::filesystem::remove(folder / "metadata.yaml");
  EXPECT_TRUE(LooksLikeBag(folder.path().string()));
  EXPECT_EQ(OpenBag(folder.path().string(), {}).scans->size(), recording.scans->size());
}

TEST(BagRecording, WhatIsNoBagIsSaidToBeNone) {
  const TempFolder folder;
  const std::string text = folder.Write("a.txt", "no bag");
  EXPECT_FALSE(LooksLikeBag(text));
  EXPECT_FALSE(LooksLikeBag(folder / "nothing"));
  EXPECT_FALSE(LooksLikeBag(folder.path().string()));
  EXPECT_THAT(TextOfError(text, {}), HasSubstr("neither a ROS 1 bag"));
  EXPECT_THAT(TextOfError(folder.Write("old.bag", "#ROSBAG V1.2\n#"), {}), HasSubstr("rosbag fix"));
}

}  // namespace
}  // namespace tvl

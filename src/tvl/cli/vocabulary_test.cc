// The images that vocabularies are trained on.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "tvl/base/check.h"
#include "tvl/cli/image_descriptors.h"
#include "tvl/io/temp_folder.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

class VocabularyImages : public testing::Test {
 protected:
  VocabularyImages() {
    for (int i = 0; i < 5; ++i) {
      const std::string name = std::to_string(i) + (i % 2 == 0 ? ".png" : ".jpg");
      cv::imwrite(folder_ / name, MakeTexture({200, 100}, static_cast<uint64_t>(i)));
    }
    folder_.Write("notes.txt", "not an image");
  }
  std::string Path() const { return folder_.path().string(); }
  TempFolder folder_;
};

TEST_F(VocabularyImages, FilesFoldersAndInputsAreFound) {
  EXPECT_EQ(FindImages({Path()}, 1).size(), 5U);
  EXPECT_EQ(FindImages({Path()}, 2).size(), 3U);
  EXPECT_EQ(FindImages({Path(), folder_ / "1.jpg"}, 1).size(), 6U);
#ifdef TVL_WITH_SIM
  EXPECT_EQ(FindImages({"sim:city?frames=7&seed=3"}, 3).size(), 3U);
  EXPECT_THROW(FindImages({"sim:city?frames=2&camera=0"}, 1), InputError);
#endif
}

TEST_F(VocabularyImages, WhatIsNoImageIsNamed) {
  EXPECT_THROW(FindImages({folder_ / "notes.txt"}, 1), InputError);
  EXPECT_THROW(FindImages({Path()}, 0), InputError);
  folder_.Write("broken.png", "nothing");
  const auto images = FindImages({folder_ / "broken.png"}, 1);
  try {
    images.at(0)();
    FAIL() << "no error";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("broken.png"), std::string::npos);
  }
}

TEST_F(VocabularyImages, ThreadsDoNotChangeDescriptors) {
  const auto images = FindImages({Path(), Path()}, 1);
  size_t reported = 0;
  const auto one = DescribeImages(images, Executor(1), [&](size_t done) { reported = done; });
  const auto two = DescribeImages(images, Executor(2), [](size_t) {});
  EXPECT_EQ(reported, 10U);
  EXPECT_EQ(one, two);
  EXPECT_EQ(one[0], one[5]);
  EXPECT_GT(one[0].size(), 20U);
}

}  // namespace
}  // namespace tvl

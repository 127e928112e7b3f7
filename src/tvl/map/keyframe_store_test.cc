#include "tvl/map/keyframe_store.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <thread>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

constexpr int kPoints = 1000;

std::shared_ptr<const KeyframePayload> Payload(int seed) {
  auto payload = std::make_shared<KeyframePayload>();
  Rng rng(static_cast<uint64_t>(seed), 1);
  for (int i = 0; i < kPoints + seed; ++i) {
    payload->cloud.planes.points.emplace_back(rng.Normal(), rng.Normal(), rng.Normal());
    payload->cloud.planes.intensity.push_back(static_cast<float>(rng.Uniform()));
  }
  payload->cloud.edges.points.emplace_back(seed, 1.0F, 2.0F);
  payload->cloud.edges.intensity.push_back(0.5F);
  payload->image.px_cam.emplace_back(3.0F, seed);
  payload->image.ray_cam.emplace_back(0.1F, 0.2F);
  payload->image.depth_m.push_back(7.5F);
  payload->image.descriptors.push_back({1, 2, 3, static_cast<uint64_t>(seed)});
  return payload;
}

void ExpectEqual(const KeyframePayload& a, const KeyframePayload& b) {
  EXPECT_EQ(a.cloud.planes.points, b.cloud.planes.points);
  EXPECT_EQ(a.cloud.planes.intensity, b.cloud.planes.intensity);
  EXPECT_EQ(a.cloud.edges.points, b.cloud.edges.points);
  EXPECT_EQ(a.cloud.edges.intensity, b.cloud.edges.intensity);
  EXPECT_EQ(a.image.px_cam, b.image.px_cam);
  EXPECT_EQ(a.image.ray_cam, b.image.ray_cam);
  EXPECT_EQ(a.image.depth_m, b.image.depth_m);
  EXPECT_EQ(a.image.descriptors, b.image.descriptors);
}

// Room for about four payloads.
KeyframeStoreOptions Small() { return {4.5 * 16.0 * kPoints / (1024.0 * 1024.0), ""}; }

TEST(KeyframeStore, GivesBackWhatWasPutFromMemoryAndFromTheFile) {
  KeyframeStore store(Small());
  for (int i = 0; i < 20; ++i) store.Put(i, Payload(i));
  EXPECT_GT(store.file_bytes(), 15U * 16U * kPoints);
  for (const int i : {0, 19, 7, 0, 12}) ExpectEqual(*store.Get(i), *Payload(i));
  EXPECT_EQ(*store.Image(3)->descriptors.begin(), Payload(3)->image.descriptors[0]);
  EXPECT_EQ(store.Cloud(5)->planes.points, Payload(5)->cloud.planes.points);
}

TEST(KeyframeStore, StaysWithinItsBoundAndWritesEachOnce) {
  KeyframeStore store(Small());
  for (int i = 0; i < 10; ++i) store.Put(i, Payload(i));
  for (int pass = 0; pass < 3; ++pass) {
    for (int i = 0; i < 10; ++i) {
      store.Get(i);
      EXPECT_LE(store.memory_bytes(), static_cast<size_t>(4.5 * 16.0 * kPoints));
    }
  }
  size_t all = 0;
  for (int i = 0; i < 10; ++i) all += SizeOf(*Payload(i)) + 8 * 8;
  EXPECT_LE(store.file_bytes(), all);
}

TEST(KeyframeStore, TheLastUsedStays) {
  KeyframeStore store(Small());
  for (int i = 0; i < 4; ++i) store.Put(i, Payload(i));
  const KeyframePayload* first = store.Get(0).get();
  store.Put(4, Payload(4));
  store.Put(5, Payload(5));
  EXPECT_EQ(store.Get(0).get(), first);  // 1 and 2 had to go
}

TEST(KeyframeStore, ReplacesAlsoWhatHasBeenWritten) {
  KeyframeStore store(Small());
  for (int i = 0; i < 10; ++i) store.Put(i, Payload(i));
  store.Put(0, Payload(77));
  for (int i = 1; i < 10; ++i) store.Get(i);
  ExpectEqual(*store.Get(0), *Payload(77));
}

TEST(KeyframeStore, SaysWhatIsWrong) {
  KeyframeStore store({0.0, "/no/such/folder"});
  for (int i = 0; i < 3; ++i) store.Put(i, Payload(i));
  EXPECT_NE(store.fault().find("/no/such/folder"), std::string::npos) << store.fault();
  for (int i = 0; i < 3; ++i) ExpectEqual(*store.Get(i), *Payload(i));
  EXPECT_THROW(store.Get(9), Error);
}

// While it lives files cannot grow beyond so many bytes, as on a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(size_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST(KeyframeStore, WhatWasWrittenBeforeTheDiskWasFullStillLeavesMemory) {
  KeyframeStore store(Small());
  {
    const FullDisk disk(5 * 17 * kPoints);  // five payloads
    for (int i = 0; i < 12; ++i) store.Put(i, Payload(i));
  }
  EXPECT_NE(store.fault(), "");
  const size_t written = store.file_bytes();
  EXPECT_GT(written, 4U * 16U * kPoints);
  for (int pass = 0; pass < 2; ++pass) {
    for (int i = 0; i < 12; ++i) {
      ExpectEqual(*store.Get(i), *Payload(i));
      // Seven that cannot be written, and the one just used.
      EXPECT_LE(store.memory_bytes(), 8U * 17U * kPoints) << "after keyframe " << i;
    }
  }
  store.Put(11, Payload(3));
  ExpectEqual(*store.Get(11), *Payload(3));
  EXPECT_EQ(store.file_bytes(), written);
}

TEST(KeyframeStore, ServesSeveralThreads) {
  KeyframeStore store(Small());
  for (int i = 0; i < 12; ++i) store.Put(i, Payload(i));
  std::vector<std::thread> readers;
  for (int thread = 0; thread < 3; ++thread) {
    readers.emplace_back([&store, thread] {
      for (int i = 0; i < 60; ++i) {
        const int index = (i * (thread + 1)) % 12;
        EXPECT_EQ(store.Get(index)->cloud.planes.points.size(),
                  static_cast<size_t>(kPoints + index));
      }
    });
  }
  for (std::thread& reader : readers) reader.join();
}

}  // namespace
}  // namespace tvl
